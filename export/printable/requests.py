"""What is asked of a part before it is meshed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from numbers import Real
from types import MappingProxyType

from export.printable.frame import check_above, check_not_below

ISLANDS = ("keep", "drop", "link")
UP: Mapping[str, tuple[int, int, int]] = MappingProxyType(
    {
        "x": (1, 0, 0),
        "-x": (-1, 0, 0),
        "y": (0, 1, 0),
        "-y": (0, -1, 0),
        "z": (0, 0, 1),
        "-z": (0, 0, -1),
    }
)
TURNS = ("keep", "fit", *UP)

_LENGTHS = {
    "wall": "a least wall",
    "gap": "a least gap",
    "strut": "a strut",
    "hollow": "a hollow wall",
    "base": "a base",
    "drain": "a drain",
}


@dataclass(frozen=True)
class Printable:
    """What makes a part printable, done in this order, on voxels; lengths in mm, None leaves a step out.

    | field | what is done | see |
    |---|---|---|
    | `wall` | walls that are thinner are made as thick | `walls_at_least` |
    | `gap` | gaps that are narrower are filled | `gaps_at_least` |
    | `smallest` | islands of less volume (mm^3) are dropped | `islands` |
    | `islands` | "keep", "drop" (all but the largest), or "link" by struts of diameter `strut` | `islands` |
    | `hollow` | all that is deeper inside than this is taken out | `hollowed` |
    | `turn` | the axis that will point up, such as "-x"; "fit" takes what fits; or "keep" | `turned` |
    | `base` | a base of this height comes under it, wider by `margin` | `with_base` |
    | `drain` | a hole of this diameter leads out of each trapped void | `drained` |
    | `fit` | the three sides of the build volume: a part that does not fit is refused | `fits` |

    Struts are as thick as `wall`, or two voxels, unless told otherwise.

    Raises `WrongLength` for lengths out of range, `ValueError` for other choices, a volume that has not three
    sides, and for what has no use: a strut where nothing is linked, a margin without a base.

    >>> Printable(wall=1.2, islands="link").asked
    True
    """

    wall: float | None = None
    gap: float | None = None
    smallest: float = 0.0
    islands: str = "keep"
    strut: float | None = None
    hollow: float | None = None
    turn: str = "keep"
    base: float | None = None
    margin: float = 0.0
    drain: float | None = None
    fit: Sequence[float] | None = None

    def __post_init__(self):
        for name, words in _LENGTHS.items():
            value = getattr(self, name)
            if value is not None:
                check_above(f"{words} in mm", _number(f"{words} in mm", value))
        for name, words in (("smallest", "the smallest volume in mm^3"), ("margin", "the margin in mm")):
            check_not_below(words, _number(words, getattr(self, name)))
        if self.islands not in ISLANDS:
            raise ValueError(f"islands are treated by one of {', '.join(ISLANDS)}; found {self.islands!r}")
        if self.turn not in TURNS:
            raise ValueError(f"a part is turned by one of {', '.join(TURNS)}; found {self.turn!r}")
        if self.fit is not None:
            object.__setattr__(self, "fit", _volume(self.fit))
        if self.strut is not None and self.islands != "link":
            raise ValueError(f"struts of {self.strut} mm have no use: islands are not linked")
        if self.margin and self.base is None:
            raise ValueError(f"a margin of {self.margin} mm has no use: there is no base")
        if self.turn == "fit" and self.fit is None:
            raise ValueError("the part is turned so that it fits: give the build volume, fit=(x, y, z) in mm")

    @property
    def asked(self) -> bool:
        """Whether there is anything to be done."""
        return any(getattr(self, each.name) != each.default for each in fields(self))

    @property
    def lengths(self) -> dict[str, float]:
        """The lengths in mm that voxels must be fine enough for, and what they are of."""
        found = {words: getattr(self, name) for name, words in _LENGTHS.items()}
        found["a margin"] = self.margin or None
        return {words: float(length) for words, length in found.items() if length is not None}


def _number(name: str, value: object) -> float:
    if not isinstance(value, Real) or isinstance(value, bool):
        raise ValueError(f"{name} is a number; found {value!r}")
    return float(value)


def _volume(sides: Sequence[float]) -> tuple[float, float, float]:
    try:
        x, y, z = sides
    except (TypeError, ValueError):
        raise ValueError(f"a build volume has three sides in mm; found {sides!r}") from None
    found = tuple(
        _number(f"side {axis} of the build volume in mm", side) for axis, side in enumerate((x, y, z))
    )
    for axis, side in enumerate(found):
        check_above(f"side {axis} of the build volume in mm", side)
    return found[0], found[1], found[2]
