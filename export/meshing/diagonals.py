"""Which diagonals of a bent square keep to its envelope; imported inside the functions that use it."""

from typing import no_type_check

import numba

MARGIN = 1e-6  # in voxels: how clearly a triangle has to stay on its side


@no_type_check
@numba.njit(cache=True)
def fits(ring, s, margin):
    """Whether the diagonal from corner s of a square leaves two triangles within its envelope.

    The envelope is made of the four tetrahedra between the centres of the two cells and a side of the
    square. In `ring` the third coordinate goes from one centre, 0, to the other, 1, and the corners turn
    counter-clockwise around this axis (Ju and Udeshi, Intersection-free contouring on an octree grid, 2006).
    """
    a = s
    ax, ay, az = ring[a, 0], ring[a, 1], ring[a, 2]
    cx, cy, cz = ring[a + 2, 0], ring[a + 2, 1], ring[a + 2, 2]
    b, d = s + 1, (s + 3) & 3
    turn = ax * cy - ay * cx
    if abs(turn) <= margin * margin:
        # the diagonal meets the axis
        dx, dy = ax - cx, ay - cy
        share = (ax * dx + ay * dy) / (dx * dx + dy * dy)
        height = az + share * (cz - az)
        return margin < height < 1 - margin
    if turn < 0:
        ax, ay, az, cx, cy, cz = cx, cy, cz, ax, ay, az
        b, d = d, b
    # the diagonal passes on the side of b, and the axis goes through the triangle a c d
    dx, dy, dz = ring[d, 0], ring[d, 1], ring[d, 2]
    bx, by, bz = ring[b, 0], ring[b, 1], ring[b, 2]
    ac, cd, da = ax * cy - ay * cx, cx * dy - cy * dx, dx * ay - dy * ax
    height = (cd * az + da * cz + ac * dz) / (ac + cd + da)
    if not margin < height < 1 - margin:
        return False
    # where the diagonal crosses the half-plane of b: within the triangle of b and the axis?
    ab, bc = ax * by - ay * bx, bx * cy - by * cx
    share = ab / (ab + bc)
    x, y, z = ax + share * (cx - ax), ay + share * (cy - ay), az + share * (cz - az)
    near = (x * bx + y * by) / (bx * bx + by * by)
    low = near * bz
    return near <= 1 and low - margin <= z <= low + (1 - near) + margin
