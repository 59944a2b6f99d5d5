"""Shapes and types of all annotated functions are checked while the tests run; how commands are run."""

import pytest
from jaxtyping import install_import_hook

PACKAGES = ["automata", "subdivision", "ifs", "fld", "trees", "export", "bcifs", "gallery"]

# As in PEP 484, an int will do where a float is asked for.
install_import_hook(PACKAGES, "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))")


@pytest.fixture
def run(capsys):
    """Runs a command; its exit code, standard output and standard error, in which there is no traceback."""
    from bcifs.__main__ import main

    def command(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return code, out, err

    return command
