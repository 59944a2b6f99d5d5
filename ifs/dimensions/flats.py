"""The maps of a shape's pieces in coordinates of the flats that they span, where they are affine."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ifs.dimensions.spans import configurations, spanning_points
from ifs.shape import Shape

_SAME = 1e-9

Rows = Float[np.ndarray, "_n _dimension"]


@dataclass(frozen=True)
class Flat:
    """The flat that the first piece of a cell spans in space: `x = origin + y @ axes`, y in mm.

    `points` are coordinates of points of the attractor that span it, `control` those of the control points,
    projected on the flat.
    """

    origin: Float[np.ndarray, "dim"]
    axes: Float[np.ndarray, "dimension dim"]
    points: Rows
    control: Rows

    def coordinates(self, places: Float[np.ndarray, "n dim"]) -> Rows:
        return (places - self.origin) @ self.axes.T

    def placed(self, rows: Rows) -> Float[np.ndarray, "_n _dim"]:
        return self.origin + rows @ self.axes


@dataclass(frozen=True)
class AffineMap:
    """`y -> linear y + shift` from the flat of the `target` cell into that of a cell."""

    target: str
    linear: Float[np.ndarray, "dimension dimension"]
    shift: Float[np.ndarray, "dimension"]

    def after(self, first: "AffineMap") -> "AffineMap":
        """This map after another one."""
        return AffineMap(first.target, self.linear @ first.linear, self.linear @ first.shift + self.shift)


@dataclass(frozen=True)
class Flats:
    """The cells of a shape with their flats, all of one dimension, and the maps of their labels."""

    dimension: int
    cells: tuple[str, ...]
    flats: Mapping[str, Flat]
    maps: Mapping[str, Mapping[str, AffineMap]]


def affine_maps(shape: Shape) -> Flats | None:
    """The maps in space that carry the first piece of each cell to the sub-pieces of the others.

    None where some piece is no affine image, and where the cells span flats of different dimensions. The
    comparison is made to 9 digits. When the shape is a point the dimension is 0.

    >>> from ifs.shape import shape
    >>> found = affine_maps(shape("takagi-curve"))
    >>> found.dimension, len(found.maps["edge"])
    (2, 2)
    """
    points = spanning_points(shape.system)
    control = configurations(shape.system, shape.control)
    size = float(np.abs(shape.control - shape.control[0]).max(initial=0.0))
    flats = {cell: _flat(points[cell].T @ control[cell], control[cell], size) for cell in control}
    dimensions = {len(flat.axes) for flat in flats.values()}
    if len(dimensions) > 1:
        return None
    maps: dict[str, dict[str, AffineMap]] = {}
    for cell in control:
        state = shape.system.states[cell]
        maps[cell] = {}
        for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
            images = flats[cell].coordinates(points[target].T @ (operator.T @ control[cell]))
            found = _fitted(flats[target].points, images)
            if found is None:
                return None
            maps[cell][label] = AffineMap(target, *found)
    return Flats(dimensions.pop(), tuple(control), flats, maps)


def _flat(places: Float[np.ndarray, "n dim"], control: Float[np.ndarray, "points dim"], size: float) -> Flat:
    differences = places[1:] - places[0]
    _, sizes, axes = np.linalg.svd(np.vstack([differences, np.zeros_like(places[:1])]), full_matrices=False)
    rank = int((sizes > _SAME * max(size, 1e-300)).sum())
    axes = np.eye(places.shape[1]) if rank == places.shape[1] else axes[:rank]
    return Flat(places[0], axes, (places - places[0]) @ axes.T, (control - places[0]) @ axes.T)


def _fitted(
    points: Float[np.ndarray, "n dimension"], images: Float[np.ndarray, "n dimension"]
) -> tuple[Float[np.ndarray, "dimension dimension"], Float[np.ndarray, "dimension"]] | None:
    sources, targets = points[1:] - points[0], images[1:] - images[0]
    linear = np.linalg.lstsq(sources, targets, rcond=None)[0] if len(sources) else np.zeros((0, 0))
    linear = linear.reshape(points.shape[1], points.shape[1])
    if np.abs(sources @ linear - targets).max(initial=0.0) > _SAME * np.abs(sources).max(initial=0.0):
        return None
    return linear.T, images[0] - linear.T @ points[0]
