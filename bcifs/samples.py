"""Curves that stand for the regions of a map, and the places that they are taken from."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from fld.classes import Region
from fld.ends import fixed_points
from fld.regions import Map


@dataclass(frozen=True)
class Sample:
    """The member that stands for a region: its place in the plane, and its curve (control points' units)."""

    place: tuple[float, float]
    points: Float[np.ndarray, "n 2"]


def middles(
    found: Map, mask: Bool[np.ndarray, "members"], smallest: float = 0.004
) -> list[tuple[float, float]]:
    """The innermost place of each connected part of a region, largest part first."""
    from scipy import ndimage

    grid = np.pad(found.grid(mask), 1)
    found_parts: Any = ndimage.label(grid)
    depth: Any = ndimage.distance_transform_edt(grid)
    parts, count = found_parts[0][1:-1, 1:-1], found_parts[1]
    inside = depth[1:-1, 1:-1]
    sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    places = []
    for part in np.argsort(-sizes, kind="stable"):
        if sizes[part] < smallest * mask.size:
            continue
        row, column = np.unravel_index(np.where(parts == part + 1, inside, 0).argmax(), parts.shape)
        places.append((float(found.x[column]), float(found.y[row])))
    return places


def sample(found: Map, region: Region) -> Sample:
    """The curve in the middle of a region's largest part, as a line through points of the attractor."""
    places = middles(found, region.members, 0.0) or middles(found, region.mirrored, 0.0)
    state = found.family.shape.system.states[found.family.shape.system.shape]
    order = [state.labels.index(label) for label in found.labels]
    steps = found.family.members(np.array(places[:1]))[0][order]
    start, last = (fixed_points(steps[k][None])[0][:, None] for k in (0, -1))
    points = start
    while points.shape[1] * len(steps) <= 20_000:
        points = np.concatenate([step @ points for step in steps], axis=1)
    drawn = np.concatenate([points, last], axis=1).T @ plane(found)
    return Sample(places[0], drawn)


def plane(found: Map) -> Float[np.ndarray, "points 2"]:
    """Control points in the plane: the first two coordinates, a line with its points on an arch."""
    control = found.family.shape.control
    return control[:, :2] if control.shape[1] > 1 else np.column_stack([control, np.zeros(len(control))])
