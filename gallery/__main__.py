"""Draw every picture of the gallery, or those named: `python -m gallery [NAME …]`."""

import sys
from importlib import import_module

from gallery import NAMES
from gallery.picture import save


def main(names: list[str]) -> int:
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        print(f"no picture {unknown[0]!r}; there are {', '.join(NAMES)}", file=sys.stderr)
        return 2
    for name in names or NAMES:
        save(name, import_module(f"gallery.{name}").build())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
