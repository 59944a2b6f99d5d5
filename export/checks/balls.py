"""Whether much larger balls fit beside a place than at it: kernels.

Imported inside the functions that use it, for numba takes a while to load.
"""

from math import sqrt
from typing import no_type_check

import numba
import numpy as np

from export.checks.boxes import DEEP

# Steps upwards, in widths: longer after one that succeeds; at last one by 3/2 radii.
STEPS = (1.0, 0.5, 0.25, 0.125)
CLIMBS = 16  # steps upwards at most
LEAST = 1e-3  # of the width: what a step gains
EACH = 15_000  # boxes looked at for a place
WAYS = 26


@no_type_check
@numba.njit(cache=True)
def away_from_triangle(a, b, c, x, y, z):
    """From the nearest point of a triangle to a point (C. Ericson, Real-Time Collision Detection, 5.1.5)."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = x - a[0], y - a[1], z - a[2]
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    s, t = 0.0, 0.0  # the nearest point is a + s u + t v
    if d1 > 0.0 or d2 > 0.0:
        qx, qy, qz = x - b[0], y - b[1], z - b[2]
        d3, d4 = ux * qx + uy * qy + uz * qz, vx * qx + vy * qy + vz * qz
        rx, ry, rz = x - c[0], y - c[1], z - c[2]
        d5, d6 = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
        over_c, over_b, over_a = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
        if d3 >= 0.0 and d4 <= d3:
            s = 1.0
        elif d6 >= 0.0 and d5 <= d6:
            t = 1.0
        elif over_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
            s = d1 / (d1 - d3) if d1 != d3 else 0.0
        elif over_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
            t = d2 / (d2 - d6) if d2 != d6 else 0.0
        elif over_a <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
            whole = (d4 - d3) + (d5 - d6)
            t = (d4 - d3) / whole if whole != 0.0 else 0.0
            s = 1.0 - t
        else:
            whole = over_a + over_b + over_c
            if whole != 0.0:
                s, t = over_b / whole, over_c / whole
    return px - s * ux - t * vx, py - s * uy - t * vy, pz - s * uz - t * vz


@no_type_check
@numba.njit(cache=True)
def _square_to_box(box, x, y, z):
    dx = max(box[0] - x, 0.0, x - box[3])
    dy = max(box[1] - y, 0.0, y - box[4])
    dz = max(box[2] - z, 0.0, z - box[5])
    return dx * dx + dy * dy + dz * dz


@no_type_check
@numba.njit(cache=True)
def clearance(points, triangles, boxes, starts, skips, x, y, z, bound, stack, limit):
    """The distance of a point to the nearest triangle, `bound` if none is nearer; which one it is, and the
    boxes looked at; -1 where these are more than the limit."""
    nearest = -1
    best = bound * bound
    node, depth, looked = 0, 0, 0
    entered = _square_to_box(boxes[0], x, y, z)
    while True:
        looked += 1
        if looked > limit:
            return -1.0, -1, looked
        if entered < best:
            if skips[node] != node + 1:
                one, other = node + 1, skips[node + 1]
                to_one = _square_to_box(boxes[one], x, y, z)
                to_other = _square_to_box(boxes[other], x, y, z)
                if to_other < to_one:
                    one, other, to_one, to_other = other, one, to_other, to_one
                if to_other < best:
                    stack[depth] = other
                    depth += 1
                node, entered = one, to_one
                continue
            for u in range(starts[node], starts[node + 1]):
                a, b, c = points[triangles[u, 0]], points[triangles[u, 1]], points[triangles[u, 2]]
                dx, dy, dz = away_from_triangle(a, b, c, x, y, z)
                square = dx * dx + dy * dy + dz * dz
                if square < best:
                    best, nearest = square, u
        if depth == 0:
            break
        depth -= 1
        node = stack[depth]
        entered = _square_to_box(boxes[node], x, y, z)
    return sqrt(best), nearest, looked


@no_type_check
@numba.njit(cache=True)
def thicker_beside(points, triangles, boxes, starts, skips, middles, directions, widths, gain, more, budget):
    """Of each place, whether a ball shows that it is a notch or a bump, and what is left of the budget.

    The place has a width w between opposite points, along a unit direction. A ball of radius r that
    stays clear of all triangles shows it where `2 r >= (gain + more s) w`, with s w <= w the distance from
    the middle to the ball. Its centre is looked for in steps upwards from the middle, each
    to a ball that overlaps the one before, so that all lie on one side of the surface.
    """
    stack = np.empty(DEEP, np.int64)
    found = np.zeros(len(middles), np.bool_)
    ways, away = np.empty((WAYS, 3)), np.empty(3)
    for i in range(len(middles)):
        if budget < 0:
            break
        width = widths[i]
        if width <= 0.0:
            continue
        mx, my, mz = middles[i, 0], middles[i, 1], middles[i, 2]
        radius, nearest, looked = clearance(
            points, triangles, boxes, starts, skips, mx, my, mz, width, stack, EACH
        )
        left = EACH - looked
        cx, cy, cz = mx, my, mz
        most = (gain + more) * width / 2  # a ball as large as that shows it wherever it is
        step, climbs, fresh = 0, 0, True
        while step <= len(STEPS) and climbs < CLIMBS and left > 0 and not found[i]:
            length = STEPS[step] * width if step < len(STEPS) else min(1.5 * radius, STEPS[-1] * width)
            best, best_way, best_nearest = radius + LEAST * width, -1, -1
            if fresh and nearest >= 0:
                one, two, three = triangles[nearest]
                away[0], away[1], away[2] = away_from_triangle(
                    points[one], points[two], points[three], cx, cy, cz
                )
                _fill_ways(directions[i], away, ways)
                fresh = False
            for way in range(WAYS):
                x, y, z = cx + length * ways[way, 0], cy + length * ways[way, 1], cz + length * ways[way, 2]
                bound = min(radius + length * 1.0000001, most)
                apart = sqrt((x - mx) ** 2 + (y - my) ** 2 + (z - mz) ** 2)
                far = max(apart - bound, 0.0) / width
                if far > 1.0 or bound <= best:
                    continue  # even the largest ball that could be there is of no use
                here, there, looked = clearance(
                    points, triangles, boxes, starts, skips, x, y, z, bound, stack, left
                )
                left -= looked
                far = max(apart - here, 0.0) / width
                if far <= 1.0 and here > best and length < 0.999999 * (radius + here):
                    best, best_way, best_nearest = here, way, there
                    if 2 * here >= (gain + more * far) * width:
                        found[i] = True
                        break
            if best_way < 0:
                step += 1
                continue
            cx += length * ways[best_way, 0]
            cy += length * ways[best_way, 1]
            cz += length * ways[best_way, 2]
            radius, nearest, fresh = best, best_nearest, True
            climbs += 1
            step = 0
        budget -= EACH - left
    return found, budget


@no_type_check
@numba.njit(cache=True)
def _fill_ways(direction, away, ways):
    """The directions to the 26 neighbours in a grid whose axes are a direction and the way off the nearest
    point, as far as that is square to it."""
    frame = np.empty((3, 3))
    frame[0] = direction
    frame[1] = away - (away * direction).sum() * direction
    if (frame[1] ** 2).sum() <= 1e-6 * (away**2).sum():
        axis = 0
        for k in range(3):
            if abs(direction[k]) < abs(direction[axis]):
                axis = k
        frame[1] = -direction[axis] * direction
        frame[1, axis] += 1.0
    frame[1] /= sqrt((frame[1] ** 2).sum())
    frame[2, 0] = direction[1] * frame[1, 2] - direction[2] * frame[1, 1]
    frame[2, 1] = direction[2] * frame[1, 0] - direction[0] * frame[1, 2]
    frame[2, 2] = direction[0] * frame[1, 1] - direction[1] * frame[1, 0]
    way = 0
    for i in range(-1, 2):
        for j in range(-1, 2):
            for k in range(-1, 2):
                if i != 0 or j != 0 or k != 0:
                    length = sqrt(float(i * i + j * j + k * k))
                    ways[way] = (i * frame[0] + j * frame[1] + k * frame[2]) / length
                    way += 1
