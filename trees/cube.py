"""Reference cubes: where in space a tree stands, and the cube that holds two of them."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from trees.doors import real, whole
from trees.errors import Misaligned, TreeError

LARGEST = 2.0**400


@dataclass(frozen=True)
class Cube:
    """The half-open cube `[origin, origin + size)`, lengths in mm.

    Origin and size are floats, so dyadic fractions: grids of two cubes are compared exactly.

    >>> Cube((0.0, 0.0), 1.0).dimension
    2
    """

    origin: tuple[float, ...]
    size: float

    def __post_init__(self):
        # Adding 0.0 turns -0.0 into 0.0: equal cubes then have equal bytes.
        if not isinstance(self.origin, Iterable):
            raise TreeError(f"an origin of {self.origin!r}: a coordinate an axis is needed")
        corner = tuple(real(x, f"origin on axis {axis}") + 0.0 for axis, x in enumerate(self.origin))
        object.__setattr__(self, "origin", corner)
        object.__setattr__(self, "size", real(self.size, "size"))
        if not 1 <= len(self.origin) <= 64:
            raise TreeError(f"a cube of {len(self.origin)} axes: 1 to 64 are possible")
        for axis, x in enumerate(self.origin):
            if abs(x) > LARGEST:
                raise TreeError(f"the origin is {x} on axis {axis}: at most {LARGEST} is possible")
        if not 1 / LARGEST <= self.size <= LARGEST:
            raise TreeError(f"a cube of size {self.size}: one from {1 / LARGEST} to {LARGEST} is needed")

    @property
    def dimension(self) -> int:
        return len(self.origin)

    @property
    def ends(self) -> tuple[float, ...]:
        """The smallest floats at or above `origin + size`: a float is below one where it is in the cube."""
        exact = [Fraction(x) + Fraction(self.size) for x in self.origin]
        near = [float(x) for x in exact]
        return tuple(y if y >= x else math.nextafter(y, math.inf) for x, y in zip(exact, near, strict=True))


def unit_cube(dimension: int) -> Cube:
    """`[0, 1)^dimension`.

    >>> unit_cube(2)
    Cube(origin=(0.0, 0.0), size=1.0)
    """
    return Cube((0.0,) * whole(dimension, "dimension"), 1.0)


def log2_ratio(large: Fraction, small: Fraction) -> int | None:
    """The integer n with `large = 2^n small`, None where there is none."""
    ratio = large / small
    n = ratio.numerator.bit_length() - ratio.denominator.bit_length()
    return n if ratio == Fraction(2) ** n else None


def steps_between(inner: Cube, outer: Cube) -> int | None:
    """0 where `inner` is a branch of `outer`, 1 where its halves are, None otherwise."""
    size, wide = Fraction(inner.size), Fraction(outer.size)
    power = log2_ratio(wide, size)
    if power is None or power < 0:
        return None
    offsets = [Fraction(a) - Fraction(b) for a, b in zip(inner.origin, outer.origin, strict=True)]
    if any(offset < 0 or offset + size > wide for offset in offsets):
        return None
    for steps in (0, 1):
        if all((offset / size * 2**steps).denominator == 1 for offset in offsets):
            return steps
    return None


def smallest_cube(low: tuple[float, ...], high: tuple[float, ...]) -> Cube:
    """The smallest cube of size `d = 2^n` that holds the points from `low` to `high`, `high` included.

    Its origin is a multiple of d; on an axis that lies on both sides of 0 it is `-d/2`, for no
    multiple of d has room there. (In Guye 1988, III.5, the search for the cube does not end then.)

    >>> smallest_cube((1.0, 5.0), (2.5, 6.0))
    Cube(origin=(0.0, 4.0), size=4.0)
    >>> smallest_cube((-0.5, 0.0), (1.0, 1.0))
    Cube(origin=(-2.0, 0.0), size=4.0)
    """
    for axis, (a, b) in enumerate(zip(low, high, strict=True)):
        if max(abs(a), abs(b)) > LARGEST / 4:
            raise TreeError(f"axis {axis}: points from {a} to {b}: at most {LARGEST / 4} is possible")
    extent = max(b - a for a, b in zip(low, high, strict=True))
    n = max(math.frexp(extent)[1] - 1, -400) if extent > 0 else 0
    while True:
        origin = _home([Fraction(x) for x in low], [Fraction(x) for x in high], Fraction(2) ** n, closed=True)
        if origin is not None:
            return Cube(tuple(float(x) for x in origin), 2.0**n)
        n += 1


def common_cube(a: Cube, b: Cube) -> Cube:
    """The cube in which the branches, or the branches' halves, of both `a` and `b` are branches.

    It is the smallest of size `2^n` at a multiple of its size (or centred at 0) where `a` and `b` are
    such cubes themselves; else the larger of the two, doubled towards the other as often as needed.

    Raises `Misaligned` where the sizes are not a power of two apart, or an offset is no multiple of
    half the smaller size; `TreeError` where the cube would be out of the range of `Cube`.

    >>> common_cube(Cube((3.0,), 1.0), Cube((4.0,), 0.5))
    Cube(origin=(0.0,), size=8.0)
    """
    if a == b:
        return a
    small, large = sorted((a, b), key=lambda cube: (cube.size, cube.origin))
    unit, size = Fraction(small.size), Fraction(large.size)
    if log2_ratio(size, unit) is None:
        raise Misaligned(f"cubes of sizes {a.size} and {b.size} mm: their ratio is no power of two")
    for axis, (x, y) in enumerate(zip(small.origin, large.origin, strict=True)):
        if ((Fraction(x) - Fraction(y)) / (unit / 2)).denominator != 1:
            raise Misaligned(
                f"axis {axis}: cubes from {small.origin[axis]} and {large.origin[axis]} mm, whose offset is "
                f"no multiple of {float(unit / 2)} mm, half the smaller size",
                axis,
            )
    return _at_home(small, large) or _doubled(small, large)


def _at_home(small: Cube, large: Cube) -> Cube | None:
    lows = [min(Fraction(x), Fraction(y)) for x, y in zip(small.origin, large.origin, strict=True)]
    highs = [
        max(Fraction(x) + Fraction(small.size), Fraction(y) + Fraction(large.size))
        for x, y in zip(small.origin, large.origin, strict=True)
    ]
    size = Fraction(large.size)
    while (origin := _home(lows, highs, size, closed=False)) is None:
        size *= 2
    if size > LARGEST:
        return None
    found = Cube(tuple(float(x) for x in origin), float(size))
    fits = all(steps_between(cube, found) is not None for cube in (small, large))
    return found if fits else None


def _home(low: list[Fraction], high: list[Fraction], size: Fraction, closed: bool) -> list[Fraction] | None:
    """The origin of the cube of this size that holds all from low to high, None where too small."""
    origin = []
    for a, b in zip(low, high, strict=True):
        for start in (size * math.floor(a / size), -size / 2):
            if start <= a and (b < start + size or (b == start + size and not closed)):
                origin.append(start)
                break
        else:
            return None
    return origin


def _doubled(small: Cube, large: Cube) -> Cube:
    size, factor = Fraction(large.size), 1
    while True:
        origin = [
            Fraction(y) - (size * (factor - 1) if x < y else 0)
            for x, y in zip(small.origin, large.origin, strict=True)
        ]
        holds = all(
            start <= Fraction(x) and Fraction(x) + Fraction(small.size) <= start + size * factor
            for start, x in zip(origin, small.origin, strict=True)
        )
        if holds:
            cube = Cube(tuple(float(x) for x in origin), float(min(size * factor, 2 * Fraction(LARGEST))))
            if [Fraction(x) for x in cube.origin] != origin:
                raise Misaligned(
                    f"the cube that holds both, of size {cube.size}, has corners that are no floating-point "
                    "numbers: give cubes whose corners have few binary digits, such as multiples of 1/1024"
                )
            return cube
        factor *= 2
