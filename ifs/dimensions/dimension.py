"""Dimensions of attractors: of pieces that are scaled copies, and bounds for the others."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from ifs.certificates.differences import components
from ifs.dimensions.affinity import affinity_bound
from ifs.dimensions.spans import configurations, spanning_points
from ifs.shape import Shape
from ifs.system import System

_SAME = 1e-9  # relative: how far a piece may be from a scaled copy
_LARGEST = 1e4  # of an exponent

Kind = Literal["similarity", "affinity"]


@dataclass(frozen=True)
class Similarity:
    """A shape all of whose pieces are scaled copies of one piece of their cell.

    `ratios[cell][label]` is the size of that sub-piece (against the first piece of its own cell) over that of
    the piece (against the first of its cell): with one cell, the contraction ratio. Sub-pieces that are
    single points are left out. `dimension` is the largest of `parts`, which holds the cells of each strongly
    connected component with a cycle, and the s of that component.
    """

    ratios: Mapping[str, Mapping[str, float]]
    dimension: float
    parts: tuple[tuple[tuple[str, ...], float], ...]
    targets: Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class Dimension:
    """A value, and whether it is the similarity dimension or an upper bound by the affinity dimension."""

    value: float
    kind: Kind


def dimension(shape: Shape) -> Dimension:
    """The similarity dimension where pieces are scaled copies, else an upper bound of the box dimension.

    The similarity dimension is the Hausdorff and the box dimension under the open set condition (see
    `ifs.dimensions.openset`); without it, it is an upper bound. Raises `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> dimension(shape("koch-curve")).kind, round(dimension(shape("koch-curve")).value, 12)
    ('similarity', 1.261859507143)
    >>> dimension(shape("takagi-curve")).kind
    'affinity'
    """
    found = similarity(shape)
    if found is not None:
        return Dimension(found.dimension, "similarity")
    return Dimension(affinity_bound(shape), "affinity")


def similarity_dimension(shape: Shape) -> float | None:
    """The s of Mauldin and Williams, where every piece is a scaled copy; None where some piece is not.

    With one cell the root of `sum_i r_i^s = 1`; with several, `M(s)_xy` is the sum of `r_i^s` over the labels
    from x to y, and s makes the largest spectral radius of a strongly connected component 1. Pieces that
    overlap are not noticed.
    Source: R. D. Mauldin, S. C. Williams, Hausdorff dimension in graph directed constructions, 1988.

    >>> from ifs.shape import shape
    >>> bool(np.isclose(similarity_dimension(shape("sierpinski-triangle")), np.log(3) / np.log(2)))
    True
    >>> similarity_dimension(shape("corner-cutting")) is None
    True
    """
    found = similarity(shape)
    return None if found is None else found.dimension


def similarity(shape: Shape) -> Similarity | None:
    """The ratios of all pieces, where each is a scaled copy; None where one is not.

    What is compared is the attractors, not the control points: with K_y points that span the attractor of y
    (`spans`), a similarity of space must carry `K_y^T P_y`, those points in the first piece of cell y, to
    `K_y^T T_i^T P_x` for every label i from x to y. Then it carries the whole attractor, whatever the control
    points that do not act on it. The comparison is made to 9 digits.

    >>> from ifs.shape import shape
    >>> {label: round(ratio, 12) for label, ratio in similarity(shape("koch-curve")).ratios["edge"].items()}
    {'0': 0.333333333333, '1': 0.333333333333, '2': 0.333333333333, '3': 0.333333333333}
    """
    system = shape.system
    points = spanning_points(system)
    control = configurations(system, shape.control)
    placed = {cell: points[cell].T @ control[cell] for cell in control}
    solid = {cell for cell, rows in placed.items() if not _is_point(rows, shape.control)}
    ratios: dict[str, dict[str, float]] = {}
    targets: dict[str, dict[str, str]] = {}
    for cell in solid:
        state = system.states[cell]
        ratios[cell], targets[cell] = {}, {}
        for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
            images = points[target].T @ (operator.T @ control[cell])
            if target not in solid and _is_point(images, control[cell]):
                continue
            ratio = _ratio(placed[target], images)
            if ratio is None:
                return None
            ratios[cell][label], targets[cell][label] = ratio, target
    parts = []
    for cells in components(system):
        cells = tuple(cell for cell in cells if cell in solid)
        if any(target in cells for cell in cells for target in targets[cell].values()):
            exponent = _root(lambda s, c=cells: _radius(_matrix(c, ratios, targets, s)))
            if exponent is None:
                return None
            parts.append((cells, exponent))
    ordered = {cell: ratios[cell] for cell in system.states if cell in solid}
    return Similarity(ordered, max((s for _, s in parts), default=0.0), tuple(parts), targets)


def natural_probabilities(system: System, found: Similarity) -> Mapping[str, Mapping[str, float]]:
    """The probabilities by which the pieces have their share of the s-dimensional measure.

    `p_i = r_i^s h_y / h_x` for label i from x to y, `M(s) h = h`; with one cell `r_i^s`. For systems whose
    cells all lead to the component that has the largest dimension; raises `ValueError` where h is not
    positive.

    >>> from ifs.shape import shape
    >>> koch = shape("koch-curve")
    >>> round(natural_probabilities(koch.system, similarity(koch))["edge"]["0"], 12)
    0.25
    """
    cells = tuple(found.ratios)
    matrix = _matrix(cells, found.ratios, found.targets, found.dimension)
    values, vectors = np.linalg.eig(matrix)
    best = int(np.argmin(np.abs(values - 1)))
    weights = np.real(vectors[:, best])
    weights = weights / weights[np.abs(weights).argmax()]
    if not (weights > 1e-12).all():
        worst = cells[int(weights.argmin())]
        raise ValueError(
            f"cell {worst!r} has no share of the {found.dimension:.6g}-dimensional measure: it never leads "
            f"to the component of that dimension. Give probabilities for each cell instead."
        )
    place = dict(zip(cells, weights, strict=True))
    return {
        cell: {
            label: _share(found, cell, label, place) if label in found.ratios.get(cell, {}) else 0.0
            for label in system.states[cell].labels
        }
        for cell in cells
    }


def _share(found: Similarity, cell: str, label: str, weights: Mapping[str, float]) -> float:
    scale = found.ratios[cell][label] ** found.dimension
    return float(scale * weights[found.targets[cell][label]] / weights[cell])


def _is_point(rows: Float[np.ndarray, "n dim"], control: Float[np.ndarray, "points dim"]) -> bool:
    size = float(np.abs(control - control[0]).max(initial=0.0))
    return float(np.abs(rows - rows[0]).max(initial=0.0)) <= _SAME * size


def _ratio(points: Float[np.ndarray, "n dim"], images: Float[np.ndarray, "n dim"]) -> float | None:
    """The factor of the similarity that carries the points to their images, if there is one."""
    sources, targets = points - points[0], images - images[0]
    _, sizes, axes = np.linalg.svd(sources, full_matrices=False)
    rank = int((sizes > _SAME * sizes.max(initial=0.0)).sum())
    if rank == 0:
        return None
    intrinsic = sources @ axes[:rank].T
    linear = np.linalg.lstsq(intrinsic, targets, rcond=None)[0]
    square = linear @ linear.T
    scale = float(np.trace(square)) / rank
    size = float(np.abs(sources).max()) * np.sqrt(scale)
    exact = np.abs(intrinsic @ linear - targets).max() <= _SAME * size
    similar = np.abs(square - scale * np.eye(rank)).max() <= _SAME * scale
    return float(np.sqrt(scale)) if exact and similar and scale > 0 else None


def _matrix(
    cells: tuple[str, ...],
    ratios: Mapping[str, Mapping[str, float]],
    targets: Mapping[str, Mapping[str, str]],
    exponent: float,
) -> Float[np.ndarray, "cells cells"]:
    place = {cell: k for k, cell in enumerate(cells)}
    matrix = np.zeros((len(cells), len(cells)))
    for cell in cells:
        for label, ratio in ratios[cell].items():
            if targets[cell][label] in place:
                matrix[place[cell], place[targets[cell][label]]] += ratio**exponent
    return matrix


def _radius(matrix: Float[np.ndarray, "n n"]) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def _root(radius: Callable[[float], float]) -> float | None:
    """Where a spectral radius, which falls as the exponent grows, passes 1; None where it never does."""
    from scipy.optimize import brentq

    if radius(0.0) <= 1 + 1e-14:
        return 0.0 if radius(1.0) < 1 else None
    high = 1.0
    while radius(high) > 1:
        high *= 2
        if high > _LARGEST:
            return None
    found = brentq(lambda s: np.log(radius(s)), 0.0, high, xtol=1e-15)
    return float(np.real(np.asarray(found)))
