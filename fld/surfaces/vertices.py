"""The vertices of a surface of patches: tangent planes of all patches around, and how they meet."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.scale import require_scale
from fld.surfaces.corners import PatchCorner, patch_corner
from fld.surfaces.rings import Ground
from ifs import Complex, Shape, draw, initial
from ifs.asked import require_shape, require_whole
from ifs.complex import refine_traced
from ifs.tangency.frames import Frame, frames

_SAME = 1e-6  # radians

Corner = tuple[str, int, int]
"""A cell, the number of a piece among those of the cell, and the number of a corner of it."""


@dataclass(frozen=True)
class Patches:
    """A surface of patches, ready to be asked about its corners and vertices. Made by `patches`."""

    complex: Complex
    ground: Ground
    frames: Mapping[str, Frame]

    @cached_property
    def faces(self) -> Mapping[int, tuple[Corner, ...]]:
        """The corners at each vertex, as `ifs.draw` numbers them."""
        found: dict[int, list[Corner]] = {}
        drawn = iter(draw(self.complex).faces)
        for cell, control in self.complex.control.items():
            for piece in range(len(control)):
                for corner, vertex in enumerate(next(drawn)[: len(self.frames[cell].corners)]):
                    found.setdefault(int(vertex), []).append((cell, piece, corner))
        return {vertex: tuple(corners) for vertex, corners in sorted(found.items())}

    def corner(self, cell: str, piece: int, number: int) -> PatchCorner:
        """How a piece of a cell leaves its corner of a number, in the order of `ifs.draw`."""
        control = np.asarray(self.complex.control[cell])[piece]
        return patch_corner(self.complex.topology, self.ground, self.frames, cell, number, control)


@dataclass(frozen=True)
class Vertex:
    """A vertex of a surface: its place in mm, the corners of the patches around it, and how they meet.

    `joint` is "smooth" (all patches have one tangent plane), "crease" (two planes, of patches side by side),
    "corner" (other planes), or None where some patch has no plane that is proven; then `words` say why.
    `normal` is that of a smooth vertex, `turn` the largest angle in degrees between two normals.
    """

    number: int
    point: Float[np.ndarray, "dim"]
    corners: tuple[tuple[Corner, PatchCorner], ...]
    joint: str | None
    normal: Float[np.ndarray, "dim"] | None
    turn: float | None
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists and numbers, ready for JSON."""
        return {
            "vertex": self.number,
            "point": [float(x) for x in self.point],
            "joint": self.joint,
            "normal": None if self.normal is None else [float(x) for x in self.normal],
            "turn": self.turn,
            "corners": [
                {"cell": cell, "piece": piece, "corner": corner, **found.as_data()}
                for (cell, piece, corner), found in self.corners
            ],
            "words": self.words,
        }


def patches(surface: Shape | Complex) -> Patches:
    """A patch, or the patches of a surface, ready to be asked.

    `ifs.surface(...).complex()` gives the latter. With other coefficients: `ifs.shape(name, values)`, or
    `surface.complex(member)` with a member of the family.

    Raises `ifs.NotParametrised` for cells that are no triangles or quadrangles cut into the like.

    >>> import ifs
    >>> found = patches(ifs.shape("catmull-clark-patch"))
    >>> found.corner("face", 0, 0).status
    'plane'
    """
    if isinstance(surface, Shape):
        surface = initial(surface.topology, surface.system, surface.control)
    elif not isinstance(surface, Complex):
        require_shape(surface)
    for control in surface.control.values():
        require_scale(np.asarray(control).reshape(-1, control.shape[2]))
    known = frames(surface.topology, list(surface.control))
    for cell in surface.control:
        if len(known[cell].corners) < 3:
            raise ValueError(
                f"cell {cell!r} is a curve: see fld.behaviour; patches are triangles or quadrangles"
            )
    return Patches(surface, Ground(surface.system), known)


def vertex(surface: Patches, number: int) -> Vertex:
    """What the patches around a vertex, as `ifs.draw` numbers it, do there, and how they meet.

    Raises `ValueError` for a number out of range, and what `ifs.bounds` raises where the system does not
    contract.

    >>> import ifs
    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> vertex(patches(ifs.surface(corners, sides).complex()), 0).joint
    'smooth'
    """
    if number not in surface.faces:
        raise ValueError(f"there is no vertex {number}: there are {len(surface.faces)}, counted from 0")
    around = [(corner, surface.corner(*corner)) for corner in surface.faces[number]]
    return _vertex(number, around)


def along_edge(surface: Patches, cell: str, piece: int, side: str, depth: int = 1) -> tuple[Vertex, ...]:
    """The vertices along a side of a piece after `depth` subdivisions, in order, its ends included.

    At each of them the patches on both sides of the edge are looked at; their `sides` hold the half-tangents
    along the edge, to either side, and across it.

    Raises `ValueError` for a cell, a piece or a side that is not there, and a negative depth.

    >>> import ifs
    >>> patch = patches(ifs.shape("catmull-clark-patch"))
    >>> [found.joint for found in along_edge(patch, "face", 0, "bottom")]
    ['smooth', 'smooth', 'smooth']
    """
    complex_ = surface.complex
    if cell not in complex_.control or not 0 <= piece < len(complex_.control[cell]):
        raise ValueError(f"there is no piece {piece} of cell {cell!r}")
    boundary = complex_.topology.automaton.cells[cell].boundary
    if side not in boundary:
        raise ValueError(f"cell {cell!r} has no side {side!r}; it has {', '.join(boundary)}")
    require_whole("depth", depth)
    edges = [(boundary[side].cell, int(complex_.boundary_at(cell, (side,), np.array([piece])).ids[0]))]
    for _ in range(depth):
        complex_, numbers = refine_traced(complex_)
        cells = complex_.topology.automaton.cells
        edges = [
            (target, int(numbers(edge, label, np.array([number]))[0]))
            for edge, number in edges
            for label, target in cells[edge].subdivision.items()
        ]
    refined = Patches(complex_, surface.ground, surface.frames)
    ids = _vertex_ids(refined)
    ends = [tuple(ids[key] for key in _ends(refined, edge, number)) for edge, number in edges]
    return tuple(vertex(refined, number) for number in _walk(ends))


def _vertex_ids(surface: Patches) -> dict[tuple[str, int], int]:
    """The number that `ifs.draw` gives to each vertex cell of the complex."""
    found = {}
    automaton = surface.complex.topology.automaton
    for number, corners in surface.faces.items():
        cell, piece, corner = corners[0]
        path = surface.frames[cell].corners[corner]
        found[automaton.end(cell, path), _number(surface, cell, path, piece)] = number
    return found


def _ends(surface: Patches, edge: str, number: int) -> list[tuple[str, int]]:
    automaton = surface.complex.topology.automaton
    return [
        (automaton.end(edge, path), _number(surface, edge, path, number))
        for path in surface.frames[edge].corners
    ]


def _number(surface: Patches, cell: str, path: tuple[str, ...], piece: int) -> int:
    return int(surface.complex.boundary_at(cell, path, np.array([piece])).ids[0])


def _walk(edges: list[tuple[int, ...]]) -> list[int]:
    """The vertices of a chain of edges, from the end that its first edge has, in order."""
    rest = [set(edge) for edge in edges]
    counts: dict[int, int] = {}
    for end in itertools.chain(*edges):
        counts[end] = counts.get(end, 0) + 1
    walk = [next((end for end in edges[0] if counts[end] == 1), edges[0][0])]
    while rest:
        step = next((edge for edge in rest if walk[-1] in edge), None)
        if step is None:
            break
        rest.remove(step)
        walk.append(next(iter(step - {walk[-1]}), walk[-1]))
    return walk


def _vertex(number: int, around: list[tuple[Corner, PatchCorner]]) -> Vertex:
    corners = [found for _, found in around]
    point = corners[0].point
    normals = [found.normal for found in corners if found.normal is not None]
    unproven = [found for found in corners if found.status not in ("plane", "two orders")]
    if unproven or len(normals) < len(corners) or not all(found.is_oriented for found in corners):
        said = "; ".join(dict.fromkeys(found.words for found in unproven or corners))
        return Vertex(number, point, tuple(around), None, None, None, said)
    angles = [_angle(one, other) for one, other in itertools.combinations(normals, 2)]
    turn = max(angles, default=0.0)
    mean = np.sum(normals, axis=0)
    if turn <= _SAME:
        normal = mean / np.linalg.norm(mean)
        said = f"smooth: {corners[0].words}"
        return Vertex(number, point, tuple(around), "smooth", normal, math.degrees(turn), said)
    groups: list[np.ndarray] = []
    for normal in normals:
        if all(_angle(normal, other) > _SAME for other in groups):
            groups.append(normal)
    joint = "crease" if len(groups) == 2 else "corner"
    said = f"{joint}: {len(groups)} tangent planes, turning by up to {math.degrees(turn):.6g} degrees"
    return Vertex(number, point, tuple(around), joint, None, math.degrees(turn), said)


def _angle(one: Float[np.ndarray, "3"], other: Float[np.ndarray, "3"]) -> float:
    return 2 * math.atan2(float(np.linalg.norm(one - other)), float(np.linalg.norm(one + other)))
