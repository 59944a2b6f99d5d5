"""The corner of a patch: its half-tangents, its tangent plane, and what it does where it has none."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from automata.topology import Topology, embedding
from fld.scale import settled
from fld.surfaces.corner_rings import corner_ring
from fld.surfaces.leaving import Leaving, leaving, order_of, rate, turning
from fld.surfaces.modes import Mode, apart, following, slowest, ways
from fld.surfaces.proofs import avoids
from fld.surfaces.rings import Ground, Ring
from fld.wording import canonical, number, written
from ifs.tangency.frames import Frame

_FLAT = 1e-9

Control = Float[np.ndarray, "_points _dim"]


@dataclass(frozen=True)
class PatchCorner:
    """How a patch leaves one of its corners.

    `status` is one of

    - "plane": the two slowest directions shrink alike; all chords tend to their plane;
    - "two orders": one direction is slowest, and the next one shrinks faster: chords tend to the plane of
      both, distances in it are like h^orders[0] and h^orders[1];
    - "several directions": three or more directions shrink alike: the tangents form a cone, no plane;
    - "line": all chords tend to one line, and no single second direction is next;
    - "undecided": as "plane", "two orders" or "line", but it is not proven that all points of the patch
      move in the plane or the line: points that do not would leave in other directions;
    - "constant": nothing that is visible moves.

    `behaviour` says what chords do in the plane: "straight" (each keeps its direction), "spiral",
    "unoriented" (each swings to its opposite), "oscillates" (moduli are equal, values are not).

    `normal` is the unit normal of the plane, for a patch in space: to the side from which the patch is seen
    counterclockwise, or one of the two where each step turns the patch over (`is_oriented` says which).
    `orders` are `log|lambda| / log r` in the uniform parameters of `ifs.at` (None where these shrink
    unequally), `moduli` the moduli of the eigenvalues they belong to, `eigenvalues` all visible ones, largest
    modulus first, and `block` the size of the dominant Jordan block.

    `sides` are the half-tangents of the edges to the next corner and to the one before, from the automata of
    the edges alone. `cone` holds, for "several directions" that are kept, the unit vectors in which some 50
    points of the patch leave: the patch tends to the cone of all of them.
    """

    point: Float[np.ndarray, "dim"]
    status: str
    behaviour: str
    normal: Float[np.ndarray, "dim"] | None
    is_oriented: bool
    orders: tuple[float | None, ...]
    moduli: tuple[float, ...]
    eigenvalues: tuple[complex, ...]
    block: int
    sides: tuple[Leaving, Leaving]
    cone: Float[np.ndarray, "ways dim"] | None
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON; eigenvalues are `[real, imaginary]`."""
        return {
            "point": [float(x) for x in self.point],
            "status": self.status,
            "behaviour": self.behaviour,
            "normal": None if self.normal is None else [float(x) for x in self.normal],
            "oriented": self.is_oriented,
            "orders": list(self.orders),
            "moduli": list(self.moduli),
            "eigenvalues": [[value.real, value.imag] for value in self.eigenvalues],
            "block": self.block,
            "sides": [side.as_data() for side in self.sides],
            "cone": None if self.cone is None else self.cone.tolist(),
            "words": self.words,
        }


def patch_corner(
    topology: Topology, ground: Ground, frames: Mapping[str, Frame], cell: str, number: int, control: Control
) -> PatchCorner:
    """How a patch with these control points leaves its corner of a number, in the order of its frame.

    Seen from the corner, the patch is the ring c + M^k (p - c). With lambda the modulus of the slowest
    visible eigenvalues of M and V the space of their eigenvectors, seen through the control points, chords
    tend to V. Where V is a line, the control points are looked at along it, and the slowest direction that
    is then visible completes the plane: the distance of all points from it is smaller than that from the
    line. Only points without a component in the plane could leave it; boxes prove that there are none.
    Source: Gentil 2010, §4.4 (the patches) and 4.2.2 (dominant eigenvectors), put together.
    """
    ring = corner_ring(topology, ground, frames, cell, number)
    sides = _sides(topology, ground, frames, cell, number, control)
    first = slowest(ring, control)
    drawn = np.array(control, dtype=float)
    place = ring.point
    for operator in reversed(ring.lead):
        place = operator @ place
    point = settled(place @ drawn, drawn)
    if first is None:
        said = "the patch stays in this point: nothing visible moves it"
        return PatchCorner(point, "constant", "straight", None, False, (), (), (), 0, sides, None, said)
    if first.spanning == 1 and len(first.vectors) == 1:
        second = following(ring, control, first)
        seen = [first] if second is None else [first, second]
    else:
        seen = [first]
    status = _status(ring, seen)
    is_plane = status in ("plane", "two orders", "undecided") and sum(len(m.vectors) for m in seen) == 2
    sense = _sense(ring, seen) if is_plane else 0
    normal = _normal(seen, sense) if is_plane and control.shape[1] == 3 else None
    orders = tuple(order_of(ring, mode) for mode in seen)
    behaviour = _behaviour(first)
    cone = ways(ring, first) if status == "several directions" else None
    words = _words(status, behaviour, normal, sense, seen, orders, cone)
    return PatchCorner(
        point,
        status,
        behaviour,
        normal,
        sense != 0,
        orders,
        tuple(mode.spectrum.modulus for mode in seen),
        first.spectrum.eigenvalues,
        first.spectrum.block,
        sides,
        cone,
        words,
    )


def _sides(
    topology: Topology, ground: Ground, frames: Mapping[str, Frame], cell: str, number: int, control: Control
) -> tuple[Leaving, Leaving]:
    """The half-tangents of the side after a corner and of the side before it, each as a curve of its own."""
    found = []
    for place, at_start in ((number, True), (number - 1, False)):
        side = frames[cell].sides[place]
        end = 0 if at_start == side.forward else 1
        ring = corner_ring(topology, ground, frames, side.cell, end)
        columns = embedding(topology.automaton, cell, (side.label,))
        points = np.array([sum(float(value) * control[row] for row, value in column) for column in columns])
        found.append(leaving(ring, points))
    return found[0], found[1]


def _status(ring: Ring, seen: list[Mode]) -> str:
    first = seen[0]
    if len(first.vectors) > 2 or first.spanning != len(first.vectors):
        return "several directions"
    if len(first.vectors) == 1 and (len(seen) == 1 or len(seen[1].vectors) > 1):
        return "line" if avoids(ring, first.rows) else "undecided"
    status = "plane" if len(first.vectors) == 2 else "two orders"
    rows = np.concatenate([mode.rows for mode in seen])
    return status if avoids(ring, rows) else "undecided"


def _behaviour(mode: Mode) -> str:
    values = mode.spectrum.values
    if len(values) == 1:
        return "straight" if values[0].real > 0 else "unoriented"
    if len(values) == 2 and values[0].imag != 0:
        return "spiral"
    return "oscillates"


def _sense(ring: Ring, seen: list[Mode]) -> int:
    """Whether the components of the other corners run counterclockwise (1), clockwise (-1), or turn (0)."""
    determinant = float(np.prod([np.linalg.det(mode.matrix) for mode in seen]))
    rows = np.concatenate([mode.rows for mode in seen])
    ways = np.array([column - ring.point for column in ring.corners]) @ rows.T
    before, after = ways[:-1], ways[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    swept = float(np.arctan2(cross, (before * after).sum(axis=1)).sum())
    return 0 if determinant < 0 or abs(swept) < _FLAT else int(np.sign(swept))


def _normal(seen: list[Mode], sense: int) -> Float[np.ndarray, "3"]:
    vectors = np.concatenate([mode.vectors for mode in seen])
    normal = np.cross(vectors[0] / np.linalg.norm(vectors[0]), vectors[1] / np.linalg.norm(vectors[1]))
    normal = normal / np.linalg.norm(normal)
    return normal * sense if sense else canonical(normal)


def _words(
    status: str,
    behaviour: str,
    normal: Float[np.ndarray, "3"] | None,
    sense: int,
    seen: list[Mode],
    orders: tuple[float | None, ...],
    cone: Float[np.ndarray, "ways dim"] | None,
) -> str:
    first = seen[0]
    rates = [rate(order, mode) for order, mode in zip(orders, seen, strict=True)]
    plane = "its plane" if normal is None else f"the plane with normal {written(normal)}"
    if status == "several directions":
        said = (
            f"no tangent plane: {len(first.vectors)} directions shrink alike, by "
            f"{first.spectrum.modulus:.6g} a step; distances are like {rates[0]}"
        )
        if cone is None:
            return f"{said}; eigenvalues {', '.join(map(number, first.spectrum.values))} dominate"
        i, j, angle = apart(cone)
        said += "; each part of the patch keeps its own direction, on a cone"
        return f"{said}: {written(cone[i])} and {written(cone[j])} are {angle:.6g} degrees apart"
    line = written(canonical(first.vectors[0] / np.linalg.norm(first.vectors[0])))
    if sum(len(mode.vectors) for mode in seen) != 2:
        rest = "the patch stays on it" if len(seen) == 1 else (
            f"across it {len(seen[1].vectors)} directions shrink alike, like {rates[1]}"
        )  # fmt: skip
        if status == "line":
            return f"no tangent plane: chords tend to the line along {line}, like {rates[0]}; {rest}"
        return (
            f"undecided: points that move along {line} tend to this line, like {rates[0]}, but it is not "
            f"proven that all of them do, and others leave otherwise; {rest}"
        )
    if len(first.vectors) == 2:
        said = f"chords tend to {plane}; distances are like {rates[0]}"
    else:
        said = f"chords tend to {plane}: like {rates[0]} along {line}, like {rates[1]} across it"
    if behaviour == "spiral":
        said += f"; in it the patch spirals, {turning(first)}"
    elif behaviour == "unoriented":
        said += (
            f"; each step turns chords to their opposites (eigenvalue {first.spectrum.values[0].real:.6g})"
        )
    elif behaviour == "oscillates":
        values = ", ".join(map(number, first.spectrum.values))
        said += f"; in it chords oscillate (eigenvalues {values} of equal modulus)"
    if not sense and normal is not None:
        said += "; each step turns the patch over, so that neither side of it is the outer one"
    if status == "undecided":
        said = f"undecided whether all parts of the patch do so: {said}"
    return said
