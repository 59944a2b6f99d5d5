"""The command `bcifs`: `main` runs one command line and returns its exit code."""

import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line (by default that of the process); the exit code.

    0 done, 2 wrong input, 3 contradiction, 4 not contracting, 5 a mesh that fails the check, 130 interrupted.
    Errors that no input should bring about come out as exceptions.

    >>> main(["solve", "no-such-file.toml"])
    2
    """
    given = sys.argv[1:] if arguments is None else arguments
    try:
        return _run(given)
    except KeyboardInterrupt:  # also while modules are still being imported
        return 130


def _run(arguments: Sequence[str]) -> int:
    from bcifs.cli import app
    from bcifs.failure import exit_code, explain
    from bcifs.values import spread

    try:
        app(spread(arguments), prog_name="bcifs")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except Exception as error:
        code = exit_code(error)
        if code is None:
            raise
        print(f"bcifs: {explain(error)}", file=sys.stderr)
        return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
