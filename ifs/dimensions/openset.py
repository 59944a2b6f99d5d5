"""The open set condition, decided where it can be, and the content of the shapes that fill an open set."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from jaxtyping import Float

from ifs.certificates.convergence import require_contraction
from ifs.certificates.polytopes import Polytope, overlap, polytope
from ifs.dimensions.flats import AffineMap, Flat, affine_maps
from ifs.shape import Shape

Verdict = Literal["holds", "fails", "undecided"]

_SAME = 1e-9
_WORDS = 4000
_CORNERS = 40
_ROUNDS = 60


@dataclass(frozen=True)
class OpenSet:
    """Whether there are open sets that contain their images, disjoint from one another.

    Where the condition holds, `sets[cell]` has the corners (mm) of a convex witness, the inside of which
    serves (in the flat that the attractor spans) for the first piece of that cell. Where it fails, `words`
    are two words from `cell` with the same map, or none when the images are too large in sum: `scale` is the
    spectral radius of `sum |det|`.
    """

    verdict: Verdict
    reason: str
    scale: float | None
    sets: Mapping[str, Float[np.ndarray, "_corners _dim"]]
    cell: str | None = None
    words: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class Content:
    """The Lebesgue measure of a shape in the flat that it spans: length, area or volume, in mm^dimension."""

    value: float | None
    dimension: int
    reason: str


def open_set(shape: Shape) -> OpenSet:
    """Decide the open set condition for pieces that are affine images of pieces of their cells.

    It fails when the images are too large in sum (the spectral radius of `sum |det|` exceeds 1), and when two
    different words of a cell, up to about 4000 in number, are the same map. It holds with a witness: the
    inside of the hull of the control points, of the hull of the attractor where that is a polytope, or of its
    box, whose images must lie inside and be disjoint. Otherwise it is undecided. Comparisons are made to 9
    digits. Flats of dimension over 3 are left undecided, as are shapes whose pieces are no affine images.

    Raises `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> found = open_set(shape("koch-curve"))
    >>> found.verdict, found.sets["edge"].shape
    ('holds', (3, 2))
    """
    require_contraction(shape.system)
    flats = affine_maps(shape)
    if flats is None:
        return OpenSet("undecided", "the pieces of a cell are no affine images of one another", None, {})
    if not flats.dimension:
        single = all(len(table) == 1 for table in flats.maps.values())
        return OpenSet("holds" if single else "undecided", "the shape is a point", None, {})
    scale = _radius(flats.cells, flats.maps)
    if scale > 1 + _SAME:
        return OpenSet("fails", f"the images have {scale:.9g} times the measure of the set", scale, {})
    repeated = _repeated(flats.maps)
    if repeated is not None:
        cell, one, other = repeated
        reason = f"in cell {cell!r} the words {' '.join(one)!r} and {' '.join(other)!r} are the same map"
        return OpenSet("fails", reason, scale, {}, cell, (one, other))
    for kind, sets in _candidates(flats.flats, flats.maps, flats.dimension):
        if _is_witness(sets, flats.maps):
            placed = {cell: flats.flats[cell].placed(found.corners) for cell, found in sets.items()}
            return OpenSet(
                "holds", f"the inside of {kind} contains its images, which are disjoint", scale, placed
            )
    return OpenSet("undecided", "none of the convex sets tried contains disjoint images of itself", scale, {})


def content(shape: Shape) -> Content:
    """The length, area or volume of a shape in the flat that it spans, where it is known.

    It is 0 when the images are smaller in sum than the whole (the spectral radius of `sum |det|` is below 1).
    When the open set condition holds with an open set that has the measure of its images, the attractor is
    the closure of that set. Otherwise the value is None. Raises `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> content(shape("menger-sponge")).value
    0.0
    """
    flats = affine_maps(shape)
    if flats is not None and flats.dimension and _radius(flats.cells, flats.maps) < 1 - _SAME:
        return Content(0.0, flats.dimension, "the images are smaller in sum than the whole")
    found = open_set(shape)
    if flats is None:
        return Content(None, int(np.linalg.matrix_rank(shape.control - shape.control[0])), found.reason)
    if flats.dimension == 0:
        return Content(0.0, 0, "the shape is a point")
    if found.verdict != "holds":
        return Content(None, flats.dimension, found.reason)
    sizes = {}
    for cell, corners in found.sets.items():
        solid = polytope(flats.flats[cell].coordinates(corners))
        assert solid is not None
        sizes[cell] = solid.volume
    for cell, table in flats.maps.items():
        images = sum(abs(np.linalg.det(move.linear)) * sizes[move.target] for move in table.values())
        if abs(images - sizes[cell]) > _SAME * sizes[cell]:
            return Content(None, flats.dimension, f"the images leave a part of the open set of {cell!r} free")
    return Content(
        float(sizes[shape.system.shape]), flats.dimension, "the attractor is the closure of the open set"
    )


def _radius(cells: tuple[str, ...], maps: Mapping[str, Mapping[str, AffineMap]]) -> float:
    place = {cell: k for k, cell in enumerate(cells)}
    matrix = np.zeros((len(cells), len(cells)))
    for cell, table in maps.items():
        for move in table.values():
            matrix[place[cell], place[move.target]] += abs(np.linalg.det(move.linear))
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))


def _repeated(
    maps: Mapping[str, Mapping[str, AffineMap]],
) -> tuple[str, tuple[str, ...], tuple[str, ...]] | None:
    """Two different words from a cell that are the same map to the same cell."""
    from scipy.spatial import KDTree

    for cell in maps:
        dim = next(iter(maps[cell].values())).linear.shape[0] if maps[cell] else 0
        level = [((), AffineMap(cell, np.eye(dim), np.zeros(dim)))]
        words: dict[str, list[tuple[tuple[str, ...], np.ndarray, float]]] = {}
        count = 0
        while level and count + len(level) * max(len(table) for table in maps.values()) <= _WORDS:
            level = [
                ((*word, label), move.after(step))
                for word, move in level
                for label, step in maps[move.target].items()
            ]
            count += len(level)
            for word, move in level:
                row = np.append(move.linear.ravel(), move.shift)
                words.setdefault(move.target, []).append((word, row, float(np.linalg.norm(move.linear))))
            if all(len(table) == 1 for table in maps.values()):
                break
        for found in words.values():
            rows = np.array([row for _, row, _ in found])
            for i, j in sorted(KDTree(rows).query_pairs(_SAME * max(1.0, float(np.abs(rows).max())))):
                if np.linalg.norm(rows[i] - rows[j]) <= _SAME * min(found[i][2], found[j][2]):
                    return cell, found[i][0], found[j][0]
    return None


def _candidates(flats: Mapping[str, Flat], maps: Mapping[str, Mapping[str, AffineMap]], dim: int):
    if dim > 3:
        return
    yield from _solid("the hull of the control points", {cell: flat.control for cell, flat in flats.items()})
    hulls = _attractor_hulls(flats, maps)
    if hulls is not None:
        yield from _solid("the hull of the attractor", hulls)
        boxes = {}
        for cell, corners in hulls.items():
            sides = np.stack([corners.min(axis=0), corners.max(axis=0)])
            grid = np.meshgrid(*sides.T, indexing="ij")
            boxes[cell] = np.stack([axis.ravel() for axis in grid], axis=1)
        yield from _solid("the box of the attractor", boxes)


def _solid(kind: str, corners: Mapping[str, np.ndarray]):
    found = {cell: polytope(points) for cell, points in corners.items()}
    sets = {cell: solid for cell, solid in found.items() if solid is not None}
    if len(sets) == len(found):
        yield kind, sets


def _attractor_hulls(
    flats: Mapping[str, Flat], maps: Mapping[str, Mapping[str, AffineMap]]
) -> dict[str, np.ndarray] | None:
    """The corners of the attractors' hulls, grown from inside; None where they are too many."""
    corners = {cell: flat.points for cell, flat in flats.items()}
    for _ in range(_ROUNDS):
        grown = {}
        for cell, table in maps.items():
            images = [corners[move.target] @ move.linear.T + move.shift for move in table.values()]
            solid = polytope(np.concatenate([corners[cell], *images]))
            if solid is None or len(solid.corners) > _CORNERS:
                return None
            grown[cell] = solid.corners
        still = all(
            grown[cell].shape == corners[cell].shape
            and np.abs(grown[cell] - corners[cell]).max() <= 1e-12 * np.abs(grown[cell]).max()
            for cell in grown
        )
        corners = grown
        if still:
            break
    return corners


def _is_witness(sets: Mapping[str, Polytope], maps: Mapping[str, Mapping[str, AffineMap]]) -> bool:
    for cell, table in maps.items():
        whole = sets[cell]
        images = []
        for move in table.values():
            corners = sets[move.target].corners @ move.linear.T + move.shift
            if (corners @ whole.normals.T - whole.offsets).max() > _SAME * whole.size:
                return False
            image = polytope(corners)
            if image is None:
                return False
            images.append(image)
        if any(overlap(one, other) > _SAME * whole.size for one, other in combinations(images, 2)):
            return False
    return True
