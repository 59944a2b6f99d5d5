"""Array shapes and types of every annotated function are checked while the tests run."""

from jaxtyping import install_import_hook

PACKAGES = ["automata", "subdivision", "ifs", "fld", "trees", "export", "bcifs", "gallery"]

# As in PEP 484, an int will do where a float is asked for.
install_import_hook(PACKAGES, "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))")
