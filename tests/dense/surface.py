"""From dense voxels to the closed triangle mesh of their boundary, square by square."""

from typing import Literal, no_type_check

import numba
import numpy as np
from dense.contacts import corner_code, join_contacts, pad
from dense.triangulate import Polygons, triangulate
from dense.voxels import EmptySolid, Solid, Voxels
from jaxtyping import Float, Int

from export.meshing.contacts import FAN_COUNT, FANS
from export.meshing.sheets import Sheets, contact_sides, exact_corners, means
from ifs.mesh import Mesh

Style = Literal["smooth", "exact"]
Contacts = Literal["join", "separate"]
CLEAR = 0.05  # a crossing keeps this share of the pitch from the centres on either side
JOINED = -0.5  # the field, in pitches, of a voxel that was filled to join a contact


def surface(
    solid: Solid | Voxels,
    style: Style = "smooth",
    contacts: Contacts = "join",
    *,
    gap: float = 0.05,
) -> Mesh:
    """The boundary of a set of voxels: closed, outward, every edge in two triangles, every vertex
    in one fan.

    `style="exact"` keeps the squares of the voxels: the volume is `count * pitch**3`.
    `style="smooth"` (surface nets) moves each vertex to the mean of the places where the field
    changes sign between the voxels on either side of its own squares, which stays within half a
    pitch of the corner in each coordinate; without a field these places are half-way. The sheets
    are the same. A square is cut along a diagonal that keeps both triangles between the two voxels
    it parts, or into four triangles around its crossing where neither diagonal does; with joined
    contacts no two triangles intersect therefore.

    `contacts="join"` first fills voxels that touch at an edge or a corner only (`join_contacts`).
    `contacts="separate"` gives each filled voxel its own sheet there; in the exact style the sheets
    are moved apart by `gap` pitches (at most 0.25; 0 leaves them in one place), so that programs
    that weld equal positions keep them apart. Empty voxels that meet at a corner alone are parted
    too. Without contacts the two do nothing.

    Vertices come in the order of the corners of the grid, extra ones last. `EmptySolid` when no
    voxel is filled, `ValueError` for an unknown style or rule, or a gap out of range.

    >>> import numpy as np
    >>> cube = surface(Voxels(np.ones((1, 1, 1), dtype=bool), np.zeros(3), 2.0), "exact")
    >>> cube.vertices.shape, cube.faces.shape
    ((8, 3), (12, 3))
    """
    if style not in ("smooth", "exact") or contacts not in ("join", "separate"):
        raise ValueError(
            f"a surface is 'smooth' or 'exact' and contacts 'join' or 'separate', "
            f"not {style!r} and {contacts!r}"
        )
    if not 0 <= gap <= 0.25:
        raise ValueError(f"the gap is a share of the pitch from 0 to 0.25, not {gap}")
    voxels, field = (solid.voxels, solid.field) if isinstance(solid, Solid) else (solid, None)
    if not voxels.filled.any():
        raise EmptySolid("no voxel is filled: there is no surface")
    if contacts == "join":
        voxels = join_contacts(voxels)
    sheets = find_sheets(voxels)
    middle = sheets.inner + 0.5 + 0.5 * sheets.normals
    if style == "exact":
        vertices, crossings = exact_corners(sheets, gap), middle
    else:
        crossings = _crossings(sheets, voxels, field)
        vertices = means(sheets, crossings)
    polygons = Polygons(vertices, sheets.squares, crossings, sheets.inner + 0.5, sheets.normals, sheets.split)
    sides, places = contact_sides(sheets, crossings, style, gap)
    vertices, faces = triangulate(polygons, sides, places)
    return Mesh(voxels.origin + vertices * voxels.pitch, faces)


def find_sheets(voxels: Voxels) -> Sheets:
    """The unit squares between filled and empty voxels, and how they hang together."""
    padded = pad(voxels.filled)
    sizes = np.array(padded.shape)
    corners, split, squares, inner, axes, contact = _sheets(padded.ravel(), sizes, FANS, FAN_COUNT)
    normals = np.zeros((len(axes), 3), dtype=np.int64)
    normals[np.arange(len(axes)), np.abs(axes) - 1] = np.sign(axes)
    return Sheets(
        np.column_stack(np.unravel_index(corners, padded.shape)),
        split,
        squares,
        np.column_stack(np.unravel_index(inner, padded.shape)) - 1,
        normals,
        contact,
    )


def _crossings(
    sheets: Sheets, voxels: Voxels, field: Float[np.ndarray, "x y z"] | None
) -> Float[np.ndarray, "squares 3"]:
    """Where the field changes sign on the way from the voxel behind a square to the one before."""
    share = np.full(len(sheets.squares), 0.5)
    if field is not None:
        low = np.minimum(_at(field, sheets.inner), 0.0) / voxels.pitch
        high = _at(field, sheets.inner + sheets.normals) / voxels.pitch
        was_empty = _at(field, sheets.inner) > 0
        low[was_empty] = JOINED
        high[np.isinf(high)] = 0.5
        share = np.clip(-low / (high - low), CLEAR, 1 - CLEAR)
    return sheets.inner + 0.5 + share[:, None] * sheets.normals


def _at(field: Float[np.ndarray, "x y z"], places: Int[np.ndarray, "n 3"]) -> Float[np.ndarray, "n"]:
    """The field at some voxels; infinite outside the grid."""
    inside = ((places >= 0) & (places < field.shape)).all(axis=1)
    values = np.full(len(places), np.inf)
    values[inside] = field[tuple(places[inside].T)]
    return values


@numba.njit(cache=True)
@no_type_check
def _count(padded, sizes, fan_count):
    step_y = sizes[2]
    step_x = sizes[1] * sizes[2]
    vertices = 0
    squares = 0
    for x in range(sizes[0] - 1):
        for y in range(sizes[1] - 1):
            for z in range(sizes[2] - 1):
                corner = x * step_x + y * step_y + z
                vertices += fan_count[corner_code(padded, corner, step_x, step_y)]
                for step in (step_x, step_y, 1):
                    squares += padded[corner] != padded[corner + step]
    return vertices, squares


@numba.njit(cache=True)
@no_type_check
def _sheets(padded, sizes, fans, fan_count):
    """See `Sheets`; `padded` is flat with an empty layer all round.

    Corner c lies above voxel c on all three axes, so it is the last corner of the three squares
    between voxel c and the next ones: when c is met, the other corners have their numbers, at most
    two layers back.
    """
    steps = (sizes[1] * sizes[2], sizes[2], 1)
    vertices, squares = _count(padded, sizes, fan_count)
    corners = np.empty(vertices, dtype=np.int64)
    split = np.zeros(vertices, dtype=np.uint8)
    faces = np.empty((squares, 4), dtype=np.int64)
    inner = np.empty(squares, dtype=np.int64)
    axes = np.empty(squares, dtype=np.int8)
    contact = np.zeros(squares, dtype=np.uint8)
    layers = 2 * steps[0]
    numbers = np.zeros(layers, dtype=np.int64)
    codes = np.zeros(layers, dtype=np.uint8)
    vertex = 0
    face = 0
    for x in range(sizes[0] - 1):
        for y in range(sizes[1] - 1):
            for z in range(sizes[2] - 1):
                c = x * steps[0] + y * steps[1] + z
                code = corner_code(padded, c, steps[0], steps[1])
                if code == 0 or code == 255:
                    continue
                numbers[c % layers] = vertex
                codes[c % layers] = code
                for _ in range(fan_count[code]):
                    corners[vertex] = c
                    split[vertex] = fan_count[code] > 1
                    vertex += 1
                for a in range(3):
                    if padded[c] == padded[c + steps[a]]:
                        continue
                    u, v = steps[(a + 1) % 3], steps[(a + 2) % 3]
                    out = padded[c]
                    full = c if out else c + steps[a]
                    empty = c + steps[a] if out else c
                    # the corners counter-clockwise seen from +a, each with its slot of axis a
                    ring = ((c - u - v, 3), (c - v, 2), (c, 0), (c - u, 1))
                    ways = (-v, u, v, -u)
                    for s in range(4):
                        t = s if out else (4 - s) % 4
                        corner, slot = ring[t]
                        place = corner % layers
                        faces[face, s] = numbers[place] + fans[codes[place], 4 * a + slot]
                        way = ways[s if out else 3 - s]
                        if not padded[full + way] and padded[empty + way]:
                            contact[face] |= 1 << s
                    inner[face] = full
                    axes[face] = a + 1 if out else -a - 1
                    face += 1
    return corners, split, faces, inner, axes, contact
