"""Plane triangles as faces, for shapes that are no smooth surface."""

import numpy as np

from export.step.error import NotPolynomial, TooManyFaces, WrongShell
from export.step.leaves import DIAGONAL, Leaf, Use
from ifs.complex import Complex, refined
from ifs.drawing import draw


def facet_leaves(complex_: Complex, depth: int, most: int) -> list[Leaf]:
    """The triangles of the mesh after `depth` subdivisions, with shared edges.

    Raises `TooManyFaces` for more than `most`, before drawing them where the pieces alone are too many, and
    `NotPolynomial` for a shape that draws no faces.
    """
    if depth < 0:
        raise ValueError(f"the depth is 0 or more, found {depth}")
    remedy = "ask for a smaller depth, or write 3MF or STL"
    for _ in range(depth):
        states = complex_.system.states
        count = sum(len(pieces) * len(states[cell].labels) for cell, pieces in complex_.control.items())
        if count > most:
            raise TooManyFaces(count, most, remedy)
        complex_ = refined(complex_, 1)
    mesh = draw(complex_)
    points, triangles = mesh.points_3d(), mesh.triangles()
    if len(triangles) > most:
        raise TooManyFaces(len(triangles), most, remedy)
    if not len(triangles):
        raise NotPolynomial(next(iter(complex_.control)), "it draws no faces")
    corners = points[triangles]
    flat = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) == 0
    if flat.any():
        x, y, z = corners[int(flat.argmax())].mean(axis=0).tolist()
        raise WrongShell("a triangle without area", (x, y, z))
    pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    _, edges = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    edges = edges.reshape(-1, 3)
    forward = triangles < np.roll(triangles, -1, axis=1)
    return [_facet(*parts) for parts in zip(corners, edges, forward, strict=True)]


def _facet(corners: np.ndarray, edges: np.ndarray, forward: np.ndarray) -> Leaf:
    """A triangle as half a parallelogram, its second side the diagonal."""
    a, b, c = corners
    control = np.stack([np.stack([a, c]), np.stack([b, b + c - a])])
    uses = tuple(
        Use(int(edge), bool(along), side, 0.0, 1.0)
        for edge, along, side in zip(edges, forward, (0, DIAGONAL, 3), strict=True)
    )
    return Leaf(control, False, uses, plane=True)
