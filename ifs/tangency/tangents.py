"""Half-tangents at the corners of pieces and normals at the vertices of a surface, at the limit.

Seen from a corner, the rest of a piece is made of ever smaller images of a part of it, under the powers of
one operator. A point of that part goes in the direction of its slowest mode that the control points do not
make vanish. A side has a half-tangent where all of its points go in one direction, and a piece has a tangent
plane where all its points go in directions of one plane; where all go along one line, as beside the end of a
crease, it is the plane of the two slowest modes.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ifs.certificates.bounds import sample
from ifs.complex import Complex
from ifs.drawing import draw
from ifs.tangency.corners import Corner, corner
from ifs.tangency.frames import frames

_NOTHING = 1e-9  # relative to the control points: a difference below this is 0
_ANGLE = 1e-6  # directions that differ by less, in radians, are one
_BLOCK = 4096  # pieces looked at together

Directions = Float[np.ndarray, "pieces corners sides dim"]
Control = Float[np.ndarray, "pieces points dim"]


@dataclass(frozen=True)
class VertexLimits:
    """The limit positions and unit normals of a surface at the vertices that `draw` numbers.

    `positions` and `normals` are `(vertices, 3)`, the positions in mm; `exists` tells where all faces at a
    vertex have the same normal, within 1e-6 radians, and elsewhere the row is NaN. `corner_normals[f, i]` is
    the normal of face f at its i-th corner, on that face's side alone: at a crease the faces differ. It is
    NaN where the face has no tangent plane.
    """

    positions: Float[np.ndarray, "vertices 3"]
    normals: Float[np.ndarray, "vertices 3"]
    exists: Bool[np.ndarray, "vertices"]
    corner_normals: Float[np.ndarray, "faces corners 3"]


def vertex_limits(complex_: Complex) -> VertexLimits:
    """Where the vertices of a surface lie at the limit, and its normals there.

    The normal of a face at a corner is the unit vector along `a x m + m x b`, a and b the half-tangents to
    the next corner and to the one before, m a direction between them: it points to where the face is seen
    counterclockwise. For Catmull and Clark's and Doo and Sabin's surfaces it exists at every vertex, for
    almost all control points.

    Raises `NotParametrised` for pieces that are no triangles or quadrangles, `ValueError` for pieces not
    in space.

    >>> from ifs.complex import initial
    >>> from ifs.shape import shape
    >>> patch = shape("catmull-clark-patch")
    >>> limits = vertex_limits(initial(patch.topology, patch.system, patch.control))
    >>> limits.normals.shape, bool(limits.exists.all())
    ((4, 3), True)
    """
    normals = [_normals(complex_, state) for state in complex_.control]
    mesh = draw(complex_)
    width = mesh.faces.shape[1]
    padded = [
        np.pad(found, ((0, 0), (0, width - found.shape[1]), (0, 0)), constant_values=np.nan)
        for found in normals
    ]
    corners = np.concatenate(padded)
    used = mesh.faces >= 0
    vertices, vectors = mesh.faces[used], corners[used]
    sums = np.zeros_like(mesh.vertices)
    np.add.at(sums, vertices, vectors)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    agree = np.linalg.norm(vectors - mean[vertices], axis=1) <= _ANGLE
    exists = np.ones(len(sums), dtype=bool)
    np.logical_and.at(exists, vertices, agree)
    mean[~exists] = np.nan
    return VertexLimits(mesh.vertices, mean, exists, corners)


def half_tangents(complex_: Complex, cell: str) -> Directions:
    """The unit half-tangents at the corners of all pieces of one cell: `(pieces, corners, sides, dim)`.

    A face has two at each corner, along the side to the next corner and along the side to the one before; a
    curve has one at each end, pointing into the curve. A row is NaN where there is none: where the curve
    oscillates or turns without end, as Koch's does, or shrinks to a point. Where control points coincide,
    slower modes vanish and the next ones count.

    Raises `NotParametrised` for cells that are no curves, triangles or quadrangles.

    >>> from ifs.complex import initial
    >>> from ifs.shape import shape
    >>> curve = shape("corner-cutting")
    >>> half_tangents(initial(curve.topology, curve.system, curve.control), "edge").shape
    (1, 2, 1, 2)
    """
    return _corner_directions(complex_, cell)[0]


def _normals(complex_: Complex, cell: str) -> Float[np.ndarray, "pieces corners 3"]:
    control = np.asarray(complex_.control[cell])
    tangents, normals = _corner_directions(complex_, cell)
    if tangents.shape[2] != 2 or control.shape[2] != 3:
        raise ValueError(
            f"only faces in space have normals; cell {cell!r} is a curve or lies in another space"
        )
    return normals


def _corner_directions(
    complex_: Complex, cell: str
) -> tuple[Directions, Float[np.ndarray, "pieces corners dim"]]:
    """The half-tangents of all pieces, and for faces in space the normals at their corners."""
    topology, system = complex_.topology, complex_.system
    found, points = frames(topology, [cell]), sample(system)
    control = np.asarray(complex_.control[cell])
    corners = len(found[cell].corners)
    sides, dimension = found[cell].reference.shape[1], control.shape[2]
    tangents = np.full((len(control), corners, sides, dimension), np.nan)
    normals = np.full((len(control), corners, dimension), np.nan)
    for number in range(corners):
        near = corner(topology, system, found, points, cell, number)
        for start in range(0, len(control), _BLOCK):
            block = slice(start, start + _BLOCK)
            directions = _directions(near, control[block])
            tangents[block, number] = _tangents(near, directions)
            if dimension == 3 and sides == 2:
                normals[block, number] = _plane(near, directions, tangents[block, number])
                rest = start + np.flatnonzero(np.isnan(normals[block, number, 0]))
                if len(rest):
                    normals[rest, number] = _second_plane(near, control[rest])
    return tangents, normals


def _directions(near: Corner, control: Control) -> Float[np.ndarray, "pieces samples dim"]:
    """Where each sample goes from the corner, as unit vectors; NaN where it goes in no one direction."""
    control = control - control.mean(axis=1, keepdims=True)
    least = _NOTHING * near.size * np.abs(control).max(axis=(1, 2))[:, None]
    result = np.full((len(control), near.along.shape[1], control.shape[2]), np.nan)
    waiting = np.ones(result.shape[:2], dtype=bool)
    for mode in near.modes:
        if not waiting.any():
            break
        moved = np.einsum("ps,npd->nsd", mode.parts, control, optimize=True)
        length = np.linalg.norm(moved, axis=2)
        seen = waiting & (length > least)
        waiting &= ~seen
        good = seen & mode.straight
        result[good] = moved[good] / length[good][:, None]
    return result


def _tangents(
    near: Corner, directions: Float[np.ndarray, "pieces samples dim"]
) -> Float[np.ndarray, "pieces sides dim"]:
    """The one direction of the samples along each side; NaN where they differ."""
    result = []
    for along in near.along:
        ways = directions[:, along]
        tangent = ways[:, 0].copy()
        apart = np.linalg.norm(ways - tangent[:, None], axis=2)
        tangent[~(apart <= _ANGLE).all(axis=1)] = np.nan
        result.append(tangent)
    return np.stack(result, axis=1)


def _plane(
    near: Corner, directions: Float[np.ndarray, "pieces samples 3"], tangents: Float[np.ndarray, "pieces 2 3"]
) -> Float[np.ndarray, "pieces 3"]:
    """The normals of the planes in which all directions lie; NaN where there is none, or only a line."""
    between = directions[:, ~near.along.any(axis=0)]
    first, last = tangents[:, :1], tangents[:, 1:]
    normal = _longest(np.cross(first, between) + np.cross(between, last))
    return np.where(_across(directions, normal)[:, None], normal, np.nan)


def _second_plane(near: Corner, control: Control) -> Float[np.ndarray, "pieces 3"]:
    """The same where all points go along one line, from the two slowest modes."""
    if len(near.modes) < 2 or not (near.modes[0].straight & near.modes[1].straight).all():
        return np.full((len(control), 3), np.nan)
    control = control - control.mean(axis=1, keepdims=True)
    slow, fast = (np.einsum("ps,npd->nsd", mode.parts, control, optimize=True) for mode in near.modes[:2])
    between = ~near.along.any(axis=0)
    first, last = (np.flatnonzero(along)[:1] for along in near.along)
    normal = _longest(
        np.cross(slow[:, first], fast[:, between])
        + np.cross(fast[:, first], slow[:, between])
        + np.cross(slow[:, between], fast[:, last])
        + np.cross(fast[:, between], slow[:, last])
    )
    flat = np.ones(len(control), dtype=bool)
    for part in (slow, fast):
        size = np.linalg.norm(part, axis=2).max(axis=1)
        flat &= _across(part / np.where(size > 0, size, 1.0)[:, None, None], normal) & (size > 0)
    return np.where(flat[:, None], normal, np.nan)


def _longest(vectors: Float[np.ndarray, "pieces samples 3"]) -> Float[np.ndarray, "pieces 3"]:
    """For each piece the longest of its vectors, made of length 1; NaN where all are about 0."""
    length = np.nan_to_num(np.linalg.norm(vectors, axis=2))
    chosen = length.argmax(axis=1)[:, None]
    most = np.take_along_axis(length, chosen, axis=1)
    some = np.take_along_axis(vectors, chosen[:, :, None], axis=1)[:, 0]
    return np.where(most > _ANGLE, some / np.where(most > _ANGLE, most, 1.0), np.nan)


def _across(
    directions: Float[np.ndarray, "pieces samples 3"], normal: Float[np.ndarray, "pieces 3"]
) -> Bool[np.ndarray, "pieces"]:
    return (np.abs(np.einsum("nsd,nd->ns", directions, normal)) <= _ANGLE).all(axis=1)
