"""The face of bcifs: the command line, and the names that Python users start from.

Every name below is imported when it is first asked for, so that `import bcifs` costs nothing.

>>> import bcifs
>>> bcifs.mesh(bcifs.shape("koch-curve"), 2).faces.shape
(16, 2)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from automata import Automaton, builtin_names, read
    from bcifs.picture import draw_mesh, draw_shape
    from export import check, make_part, read_mesh, write_part
    from fld import behaviour
    from ifs import Mesh, Shape, mesh, shape
    from subdivision import Solution, solve

_HOME = {
    "Automaton": "automata",
    "Mesh": "ifs",
    "Shape": "ifs",
    "Solution": "subdivision",
    "behaviour": "fld",
    "builtin_names": "automata",
    "check": "export",
    "draw_mesh": "bcifs.picture",
    "draw_shape": "bcifs.picture",
    "make_part": "export",
    "mesh": "ifs",
    "read": "automata",
    "read_mesh": "export",
    "shape": "ifs",
    "solve": "subdivision",
    "write_part": "export",
}

__all__ = [
    "Automaton",
    "Mesh",
    "Shape",
    "Solution",
    "behaviour",
    "builtin_names",
    "check",
    "draw_mesh",
    "draw_shape",
    "make_part",
    "mesh",
    "read",
    "read_mesh",
    "shape",
    "solve",
    "write_part",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'bcifs' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
