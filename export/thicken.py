"""Thickening a set of voxels by a distance."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy import ndimage, spatial

from export.facets import Facets
from export.voxels import EmptySolid, Solid, Voxels
from ifs import Mesh

SLAB = 8_000_000  # voxels worked on at a time
FARTHEST = 4  # pitches between voxels and the facets said to be of the same shape
BAND = 2  # how many voxels outside the surface the field is exact


def thicken(voxels: Voxels, distance: float, facets: Mesh | None = None, *, slab: int = SLAB) -> Solid:
    """The solid within `distance` (mm) of a set of voxels, with its distance field.

    Without `facets` it is every voxel whose centre lies within `distance` of the centre of a set
    voxel. `facets` replaces the centres by a mesh of the shape itself (points, segments or
    triangles, mm, about as small as voxels): the surface then follows the shape instead of its
    voxels, and the set voxels themselves stay in whatever the distance. The field is
    `distance to the nearest facet - max(distance, pitch / 2)` (exact next to the surface, cut off
    at two pitches outside); so a smooth wall is about one pitch thick at least.

    The grid grows so that its border stays empty. The exact Euclidean transform runs over slabs of
    about `slab` voxels, so it costs about 40 bytes for each of these and, for the answer, 5 bytes
    for each voxel of the grown grid; facets cost about 200 bytes each.

    Raises `EmptySolid` for an empty set, `ValueError` for a distance that is negative or not
    finite, and for facets that are not finite or more than four pitches away from the voxels.

    >>> import numpy as np
    >>> dot = Voxels(np.ones((1, 1, 1), dtype=bool), np.zeros(3), 1.0)
    >>> thicken(dot, 1.0).voxels.count
    7
    """
    if not (math.isfinite(distance) and distance >= 0):
        raise ValueError(f"the distance must be finite and not negative, not {distance} mm")
    if not voxels.filled.any():
        raise EmptySolid("no voxel is filled: there is nothing to thicken")
    level = max(distance / voxels.pitch, 0.5) * (1 + 1e-12)
    near = None if facets is None else _near(voxels, facets)
    margin = math.floor(level + (near.drift if near else 0)) + 1
    grown = Voxels(np.pad(voxels.filled, margin), voxels.origin - margin * voxels.pitch, voxels.pitch)
    field = _field(grown, near, level, slab)
    return Solid(Voxels(field <= 0, grown.origin, grown.pitch), field)


@dataclass(frozen=True, eq=False)
class _Near:
    """The facets of a shape, and how many pitches their distances may differ from those of centres."""

    facets: Facets
    drift: float


def _near(voxels: Voxels, mesh: Mesh) -> _Near:
    if not np.isfinite(mesh.vertices).all():
        raise ValueError("the vertices of the facets must be finite numbers of millimetres")
    facets = Facets(mesh)
    centres = voxels.centres()
    to_facets = float(facets.distance(centres).max())
    to_centres = float(spatial.KDTree(centres).query(mesh.points_3d(), workers=-1)[0].max())
    drift = max(to_facets, to_centres + facets.longest) / voxels.pitch
    if drift > FARTHEST:
        raise ValueError(f"facets and voxels differ by {drift:.3g} pitches ({FARTHEST} allowed)")
    return _Near(facets, drift)


def _field(voxels: Voxels, near: _Near | None, level: float, slab: int) -> Float32[np.ndarray, "x y z"]:
    """Distance minus level in mm, slab by slab; a slab sees as far around as it has to."""
    filled = voxels.filled
    reach = math.ceil(level + (near.drift if near else 0)) + BAND + 1
    step = max(slab // (filled.shape[1] * filled.shape[2]) - 2 * reach, reach)
    field = np.empty(filled.shape, dtype=np.float32)
    for start in range(0, len(filled), step):
        stop = min(start + step, len(filled))
        low, high = max(start - reach, 0), min(stop + reach, len(filled))
        distances = _distances(filled[low:high], start - low, stop - low)
        if near is not None:
            _correct(
                distances, near, level, voxels.origin + np.array([start * voxels.pitch, 0, 0]), voxels.pitch
            )
        part = np.minimum(distances - level, BAND) * voxels.pitch
        part[filled[start:stop] & (part > 0)] = 0
        field[start:stop] = _signed(part)
    return field


def _correct(
    distances: Float[np.ndarray, "slab y z"],
    near: _Near,
    level: float,
    origin: Float[np.ndarray, "3"],
    pitch: float,
) -> None:
    """Distances to the facets instead of to the centres, near the surface.

    The two differ by `drift` at most, so a voxel further than `drift + 1` from the level by its
    centre is on the known side of the surface, and so are the voxels next to it.
    """
    places = np.argwhere(np.abs(distances - level) <= near.drift + 1.01)
    if len(places):
        distances[tuple(places.T)] = near.facets.distance(origin + (places + 0.5) * pitch) / pitch


def _signed(part: Float[np.ndarray, "x y z"]) -> Float32[np.ndarray, "x y z"]:
    """To float32 without a positive value becoming zero."""
    rounded = part.astype(np.float32)
    rounded[(part > 0) & (rounded <= 0)] = np.finfo(np.float32).tiny
    return rounded


def _distances(filled: Bool[np.ndarray, "x y z"], start: int, stop: int) -> Float[np.ndarray, "slab y z"]:
    """From the centre of each voxel of a slab to that of its nearest filled one, in voxels."""
    if not filled.any():
        return np.full((stop - start, *filled.shape[1:]), np.inf)
    nearest = ndimage.distance_transform_edt(~filled, return_distances=False, return_indices=True)
    assert isinstance(nearest, np.ndarray)
    sizes = nearest.shape[1:]
    total = np.zeros((stop - start, *sizes[1:]))
    for axis, size in enumerate(sizes):
        here = np.arange(size).reshape([-1 if other == axis else 1 for other in range(3)])
        gap = nearest[axis, start:stop] - (here[start:stop] if axis == 0 else here)
        total += gap.astype(np.float64) ** 2
    return np.sqrt(total)
