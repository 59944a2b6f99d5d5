"""Faces joined along their edges: shared curves and corners, and how well neighbours agree."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, Int

from export.step.error import WrongShell
from export.step.leaves import DIAGONAL, Leaf, Use
from export.step.polynomial import bernstein

_SAMPLES = 9

Poles = Float[np.ndarray, "_poles 3"]


@dataclass(frozen=True)
class Sheet:
    """Faces with shared edges and corners, lengths in mm.

    `curves[e]` holds the Bernstein control points of edge e; `ends[e]` the numbers of its two corners, which
    lie at `points`; `users[e]` the faces at it with their uses of it (one at the rim, else two); `shell[f]`
    is the number of the connected part that face f belongs to; `closed[s]` says whether part s has no rim.
    `gap` is the largest distance between a face and its edge curve, at equal parameters; `angle` the
    largest angle between the normals of two faces across an edge, in degrees, and `angle_fitted` the same
    where at least one of them is fitted.
    """

    leaves: Sequence[Leaf]
    curves: dict[int, Poles]
    ends: dict[int, tuple[int, int]]
    points: Float[np.ndarray, "corners 3"]
    users: dict[int, list[tuple[int, Use]]]
    shell: Int[np.ndarray, "faces"]
    closed: tuple[bool, ...]
    gap: float
    angle: float
    angle_fitted: float


def joined(leaves: Sequence[Leaf]) -> Sheet:
    """The sheet of faces that name their edges.

    Raises `WrongShell` where more than two faces share an edge, or two walk along it the same way.
    """
    users: dict[int, list[tuple[int, Use]]] = {}
    for face, leaf in enumerate(leaves):
        for use in leaf.uses:
            users.setdefault(use.edge, []).append((face, use))
    curves = {edge: _curve(leaves, found) for edge, found in users.items()}
    for edge, found in users.items():
        _check(found, curves[edge])
    ends, points = _corners(leaves, curves)
    shell = _shells(len(leaves), users)
    closed = np.ones(int(shell.max()) + 1, dtype=bool)
    for found in users.values():
        closed[shell[found[0][0]]] &= len(found) == 2
    gap, angle, fitted = _defects(leaves, curves, users)
    return Sheet(leaves, curves, ends, points, users, shell, tuple(closed.tolist()), gap, angle, fitted)


def side_poles(leaf: Leaf, side: int) -> Poles:
    """The Bernstein control points of a side, as the face is walked."""
    control = leaf.control
    if side == DIAGONAL:
        return np.stack([control[1, 0], control[0, 1]])
    return (control[:, 0], control[-1, :], control[::-1, -1], control[0, ::-1])[side]


def side_parameters(side: int, t: Float[np.ndarray, "samples"]) -> Float[np.ndarray, "samples 2"]:
    """Where on the unit square of a face the points of a side are."""
    zero, one = np.zeros_like(t), np.ones_like(t)
    u, v = ((t, zero), (one, t), (1 - t, one), (zero, 1 - t), (1 - t, t))[side]
    return np.stack([u, v], axis=1)


def _curve(leaves: Sequence[Leaf], found: list[tuple[int, Use]]) -> Poles:
    """The curve of an edge, from a face whose whole side it is where there is one."""
    face, use = max(found, key=lambda pair: pair[1].t1 - pair[1].t0)
    poles = side_poles(leaves[face], use.side)
    if (use.t0, use.t1) != (0.0, 1.0):
        degree = len(poles) - 1
        t = np.linspace(0, 1, degree + 1)
        values = bernstein(degree, use.t0 + (use.t1 - use.t0) * t) @ poles
        poles = np.linalg.solve(bernstein(degree, t), values)
    return poles if use.forward else poles[::-1]


def _check(found: list[tuple[int, Use]], curve: Poles) -> None:
    x, y, z = (float(c) for c in bernstein(len(curve) - 1, np.array([0.5]))[0] @ curve)
    if len(found) > 2:
        raise WrongShell(f"{len(found)} faces share an edge, a surface has two at most,", (x, y, z))
    if len(found) == 2 and found[0][1].forward == found[1][1].forward:
        reason = (
            "two faces walk along their common edge in the same direction, so that their normals disagree,"
        )
        raise WrongShell(reason, (x, y, z))


def _corners(
    leaves: Sequence[Leaf], curves: dict[int, Poles]
) -> tuple[dict[int, tuple[int, int]], Float[np.ndarray, "corners 3"]]:
    """Ends of edges that meet in a face's walk are one corner."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    place = {edge: i for i, edge in enumerate(curves)}
    one, other = [], []
    for leaf in leaves:
        for before, after in zip(leaf.uses, (*leaf.uses[1:], leaf.uses[0]), strict=True):
            one.append(2 * place[before.edge] + before.forward)
            other.append(2 * place[after.edge] + (not after.forward))
    size = 2 * len(place)
    links = coo_array((np.ones(len(one)), (one, other)), shape=(size, size))
    count, corner = connected_components(links, directed=False)
    points = np.zeros((count, 3))
    for edge, i in place.items():
        points[corner[2 * i]], points[corner[2 * i + 1]] = curves[edge][0], curves[edge][-1]
    return {e: (int(corner[2 * i]), int(corner[2 * i + 1])) for e, i in place.items()}, points


def _shells(count: int, users: dict[int, list[tuple[int, Use]]]) -> Int[np.ndarray, "faces"]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = np.array([(found[0][0], found[-1][0]) for found in users.values()])
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _defects(
    leaves: Sequence[Leaf], curves: dict[int, Poles], users: dict[int, list[tuple[int, Use]]]
) -> tuple[float, float, float]:
    along_edge = cache(lambda degree: bernstein(degree, np.linspace(0, 1, _SAMPLES)))
    gap = angle = fitted = 0.0
    for edge, found in users.items():
        along = along_edge(len(curves[edge]) - 1) @ curves[edge]
        normals = []
        for face, use in found:
            points, normal = _points_and_normals(leaves[face].control, use)
            gap = max(gap, float(np.linalg.norm(points - along, axis=1).max()))
            normals.append(normal)
        if len(normals) == 2:
            across = np.linalg.norm(np.cross(*normals), axis=1)
            between = np.degrees(np.arctan2(across, (normals[0] * normals[1]).sum(axis=1))).max()
            angle = max(angle, float(between))
            if any(not (leaves[face].exact or leaves[face].plane) for face, _ in found):
                fitted = max(fitted, float(between))
    return gap, angle, fitted


def _points_and_normals(control: np.ndarray, use: Use) -> tuple[np.ndarray, np.ndarray]:
    """Points of a face along an edge, in the direction of the edge, and its normals, not of unit length."""
    bases = _bases(len(control) - 1, use.side, use.t0, use.t1, use.forward)
    flat = [part.reshape(-1, 3) for part in (control, np.diff(control, axis=0), np.diff(control, axis=1))]
    point, along, across = (basis @ part for basis, part in zip(bases, flat, strict=True))
    return point, np.cross(along, across)


@cache
def _bases(degree: int, side: int, t0: float, t1: float, forward: bool) -> tuple[np.ndarray, ...]:
    """Weights of a face's control points, and of their differences, at the samples of a part of a side."""
    s = np.linspace(0, 1, _SAMPLES)
    place = side_parameters(side, t0 + (t1 - t0) * (s if forward else 1 - s))
    (b, c), (db, dc) = ([bernstein(d, place[:, k]) for k in (0, 1)] for d in (degree, degree - 1))
    products = (np.einsum("si,sj->sij", *pair).reshape(_SAMPLES, -1) for pair in ((b, c), (db, c), (b, dc)))
    return tuple(products)
