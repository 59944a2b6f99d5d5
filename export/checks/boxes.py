"""A binary tree of boxes over triangles, and the pairs and rays that are looked for in it.

The triangles stand in the order of a space-filling curve. A node holds triangles that follow each
other, from `starts[node]`, and is split where the highest bit of their keys changes. Nodes stand in
preorder: after a node comes its first child, and `skips[node]` is the first node that is not below
it; so a node is a leaf where that is the next one, and the second child is `skips[node + 1]`.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

from export.checks.pairs import APART, flat_axis, meet
from export.checks.predicates import ROOM

LEAF = 4  # triangles of a leaf, at most
DEEP = 128  # levels of the tree, at most


@no_type_check
@numba.njit(cache=True)
def curve_keys(points, triangles, low, scale):
    """Morton keys, 21 bits an axis, of the middles of the boxes of the triangles."""
    keys = np.empty(len(triangles), np.uint64)
    for t in range(len(triangles)):
        key = np.uint64(0)
        for axis in range(3):
            x = points[triangles[t, 0], axis]
            y = points[triangles[t, 1], axis]
            z = points[triangles[t, 2], axis]
            middle = ((min(x, y, z) + max(x, y, z)) / 2 - low[axis]) * scale
            v = np.uint64(min(max(middle, 0.0), 2097151.0))
            v = (v | (v << np.uint64(32))) & np.uint64(0x1F00000000FFFF)
            v = (v | (v << np.uint64(16))) & np.uint64(0x1F0000FF0000FF)
            v = (v | (v << np.uint64(8))) & np.uint64(0x100F00F00F00F00F)
            v = (v | (v << np.uint64(4))) & np.uint64(0x10C30C30C30C30C3)
            v = (v | (v << np.uint64(2))) & np.uint64(0x1249249249249249)
            key |= v << np.uint64(axis)
        keys[t] = key
    return keys


@no_type_check
@numba.njit(cache=True)
def grow_nodes(keys):
    """`starts` (with the number of triangles at its end) and `skips` of the nodes over sorted keys."""
    starts = np.empty(2 * len(keys) + 1, np.int32)
    skips = np.empty(2 * len(keys), np.int32)
    ranges = np.empty((DEEP, 2), np.int64)
    n, waiting, first, last = 0, 0, 0, len(keys)
    while True:
        starts[n] = first
        if last - first > LEAF:
            middle = _split(keys, first, last)
            skips[n] = 0
            ranges[waiting, 0], ranges[waiting, 1] = middle, last
            waiting += 1
            last = middle
            n += 1
            continue
        skips[n] = n + 1
        n += 1
        if waiting == 0:
            break
        waiting -= 1
        first, last = ranges[waiting, 0], ranges[waiting, 1]
    starts[n] = len(keys)
    for node in range(n - 1, -1, -1):
        if skips[node] == 0:
            skips[node] = skips[skips[node + 1]]
    return starts[: n + 1].copy(), skips[:n].copy()


@no_type_check
@numba.njit(cache=True)
def _split(keys, first, last):
    """Where the highest bit changes; the middle where all keys are equal."""
    differ = keys[first] ^ keys[last - 1]
    if differ == np.uint64(0):
        return (first + last) // 2
    bit = np.uint64(1)
    while differ > np.uint64(1):
        differ >>= np.uint64(1)
        bit <<= np.uint64(1)
    low, high = first, last - 1  # the bit is 0 at low and 1 at high
    while high - low > 1:
        middle = (low + high) // 2
        if keys[middle] & bit:
            high = middle
        else:
            low = middle
    return high


@no_type_check
@numba.njit(cache=True)
def grow_boxes(points, triangles, starts, skips):
    """The boxes `(nodes, 6)`, low then high."""
    boxes = np.empty((len(skips), 6))
    boxes[:, :3] = np.inf
    boxes[:, 3:] = -np.inf
    for node in range(len(skips) - 1, -1, -1):
        box = boxes[node]
        if skips[node] == node + 1:
            for t in range(starts[node], starts[node + 1]):
                for corner in range(3):
                    for axis in range(3):
                        x = points[triangles[t, corner], axis]
                        box[axis] = min(box[axis], x)
                        box[3 + axis] = max(box[3 + axis], x)
            continue
        one, other = boxes[node + 1], boxes[skips[node + 1]]
        for axis in range(3):
            box[axis] = min(one[axis], other[axis])
            box[3 + axis] = max(one[3 + axis], other[3 + axis])
    return boxes


@no_type_check
@numba.njit(cache=True)
def crossing_pairs(points, triangles, boxes, starts, skips, first, last, found, count, budget):
    """Pairs of triangles that meet, of which the earlier one is in one of the nodes `first` to `last`.

    Triangles of the same three vertices are passed over. Pairs are written into the rows of `found`
    while there is room. Returns how many were found, with `count` before, and what is left of the
    budget (boxes looked at; an exact test costs 32); the search ends where the budget does.
    """
    room = np.empty(ROOM)
    p, q = np.empty((3, 3)), np.empty((3, 3))
    for leaf in range(first, last):
        if skips[leaf] != leaf + 1:
            continue
        for t in range(starts[leaf], starts[leaf + 1]):
            for corner in range(3):
                for axis in range(3):
                    p[corner, axis] = points[triangles[t, corner], axis]
            if flat_axis(p[0], p[1], p[2], room) < 0:
                continue
            x0, x1 = min(p[0, 0], p[1, 0], p[2, 0]), max(p[0, 0], p[1, 0], p[2, 0])
            y0, y1 = min(p[0, 1], p[1, 1], p[2, 1]), max(p[0, 1], p[1, 1], p[2, 1])
            z0, z1 = min(p[0, 2], p[1, 2], p[2, 2]), max(p[0, 2], p[1, 2], p[2, 2])
            node = leaf
            while node < len(skips):  # what comes later in preorder are just the later triangles
                budget -= 1
                box = boxes[node]
                if box[0] > x1 or box[3] < x0 or box[1] > y1 or box[4] < y0 or box[2] > z1 or box[5] < z0:
                    node = skips[node]
                    continue
                if skips[node] == node + 1:
                    for u in range(max(starts[node], t + 1), starts[node + 1]):
                        a, b, c = points[triangles[u, 0]], points[triangles[u, 1]], points[triangles[u, 2]]
                        if (
                            min(a[0], b[0], c[0]) > x1 or max(a[0], b[0], c[0]) < x0
                            or min(a[1], b[1], c[1]) > y1 or max(a[1], b[1], c[1]) < y0
                            or min(a[2], b[2], c[2]) > z1 or max(a[2], b[2], c[2]) < z0
                        ):  # fmt: skip
                            continue
                        budget -= 32
                        for axis in range(3):
                            q[0, axis], q[1, axis], q[2, axis] = a[axis], b[axis], c[axis]
                        if _same(triangles[t], triangles[u]) or flat_axis(a, b, c, room) < 0:
                            continue
                        if meet(p, q, room) != APART:
                            if count < len(found):
                                found[count, 0], found[count, 1] = t, u
                            count += 1
                node += 1
            if budget < 0:
                return count, budget
    return count, budget


@no_type_check
@numba.njit(cache=True)
def _same(t, u):
    found = 0
    for i in range(3):
        if t[i] == u[0] or t[i] == u[1] or t[i] == u[2]:
            found += 1
    return found == 3


@no_type_check
@numba.njit(cache=True)
def first_hits(
    points, triangles, boxes, starts, skips, origins, directions, own, near, leaving, distances, hits, budget
):
    """The first triangle that each ray meets, and where, as a multiple of its direction.

    The triangle `own` is passed over. Triangles within `near` of the start count as met at 0, where the ray
    leaves through their back (`leaving`) or else enters through their front, and are passed over if not.
    -1 and infinity where there is none. Returns what is left of the budget of boxes looked at; the
    search ends where the budget does.
    """
    stack = np.empty(DEEP, np.int64)
    for ray in range(len(origins)):
        if budget < 0:
            break
        ox, oy, oz = origins[ray, 0], origins[ray, 1], origins[ray, 2]
        dx, dy, dz = directions[ray, 0], directions[ray, 1], directions[ray, 2]
        ix, iy, iz = _inverse(dx), _inverse(dy), _inverse(dz)
        best, hit = np.inf, -1
        node, depth = 0, 0
        entered = _enters(boxes[0], ox, oy, oz, ix, iy, iz, near)
        while True:
            budget -= 1
            if entered < best:
                if skips[node] != node + 1:
                    one, other = node + 1, skips[node + 1]
                    to_one = _enters(boxes[one], ox, oy, oz, ix, iy, iz, near)
                    to_other = _enters(boxes[other], ox, oy, oz, ix, iy, iz, near)
                    if to_other < to_one:
                        one, other, to_one, to_other = other, one, to_other, to_one
                    if to_other < best:
                        stack[depth] = other
                        depth += 1
                    node, entered = one, to_one
                    continue
                for u in range(starts[node], starts[node + 1]):
                    if u == own[ray]:
                        continue
                    a, b, c = points[triangles[u, 0]], points[triangles[u, 1]], points[triangles[u, 2]]
                    t, det, _, _ = meets_line(a, b, c, ox, oy, oz, dx, dy, dz)
                    if -near <= t < best and (t > near or (det < 0) == leaving):
                        best, hit = t, u
            if depth == 0:
                break
            depth -= 1
            node = stack[depth]
            entered = _enters(boxes[node], ox, oy, oz, ix, iy, iz, near)
        distances[ray], hits[ray] = max(best, 0.0), hit
    return budget


@no_type_check
@numba.njit(cache=True)
def _inverse(x):
    return 1.0 / x if abs(x) > 1e-300 else 1e300


@no_type_check
@numba.njit(cache=True)
def _enters(box, ox, oy, oz, ix, iy, iz, near):
    """Where a ray enters a box that is wider by `near`, or infinity; i: what its direction goes into 1."""
    one, other = (box[0] - near - ox) * ix, (box[3] + near - ox) * ix
    start, end = min(one, other), max(one, other)
    one, other = (box[1] - near - oy) * iy, (box[4] + near - oy) * iy
    start, end = max(start, min(one, other)), min(end, max(one, other))
    one, other = (box[2] - near - oz) * iz, (box[5] + near - oz) * iz
    start, end = max(start, min(one, other)), min(end, max(one, other))
    return start if start <= end and end >= -near else np.inf


@no_type_check
@numba.njit(cache=True)
def meets_line(a, b, c, ox, oy, oz, dx, dy, dz):
    """Where a line meets a triangle (infinity: nowhere), its determinant, and the two coordinates there.

    Moeller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
    det = ux * px + uy * py + uz * pz
    if det == 0.0:
        return np.inf, 0.0, 0.0, 0.0
    sx, sy, sz = ox - a[0], oy - a[1], oz - a[2]
    s = (sx * px + sy * py + sz * pz) / det
    rx, ry, rz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    r = (dx * rx + dy * ry + dz * rz) / det
    if s < -1e-9 or r < -1e-9 or s + r > 1 + 1e-9:
        return np.inf, det, s, r
    return (vx * rx + vy * ry + vz * rz) / det, det, s, r


@no_type_check
@numba.njit(cache=True)
def windings(points, triangles, boxes, starts, skips, shell, counted, places, skip, direction, near, budget):
    """How often the counted shells wind around each place, whether the ray told, and the budget left.

    Along a ray from the place, a triangle that is left through its back counts 1, one that is
    entered through its front -1; the shell `skip` is passed over. A ray that passes too close to an edge,
    or starts on a triangle, does not tell; nor does any after the budget of boxes looked at is spent.
    """
    winding = np.zeros(len(places), np.int64)
    sure = np.ones(len(places), np.bool_)
    dx, dy, dz = direction[0], direction[1], direction[2]
    ix, iy, iz = _inverse(dx), _inverse(dy), _inverse(dz)
    for i in range(len(places)):
        ox, oy, oz = places[i, 0], places[i, 1], places[i, 2]
        if budget < 0:
            sure[i] = False
            continue
        node = 0
        while node < len(skips):
            budget -= 1
            if _enters(boxes[node], ox, oy, oz, ix, iy, iz, near) == np.inf:
                node = skips[node]
                continue
            if skips[node] == node + 1:
                for u in range(starts[node], starts[node + 1]):
                    if shell[u] == skip[i] or not counted[shell[u]]:
                        continue
                    a, b, c = points[triangles[u, 0]], points[triangles[u, 1]], points[triangles[u, 2]]
                    t, det, s, r = meets_line(a, b, c, ox, oy, oz, dx, dy, dz)
                    if t < -near or t == np.inf:
                        continue
                    if t <= near or min(s, r, 1 - s - r) < 1e-9:
                        sure[i] = False
                    winding[i] += -1 if det > 0 else 1
            node += 1
    return winding, sure, budget
