"""Where the vertices of bent squares go, and their triangles; imported inside the functions that use it."""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.diagonals import fits

THIN = 1e-5


@no_type_check
@numba.njit(cache=True)
def means(starts, ring, crossings, inner, outer, places, smallest, largest):
    """At each vertex the mean of its squares' crossings, and the edges of the blocks beside these."""
    counts = np.zeros(places.shape[0], np.int32)
    for f in range(starts.size - 1):
        small, large = min(inner[f], outer[f]), max(inner[f], outer[f])
        for i in range(starts[f], starts[f + 1]):
            vertex = ring[i]
            counts[vertex] += 1
            for a in range(3):
                places[vertex, a] += crossings[f, a]
            if counts[vertex] == 1:
                smallest[vertex], largest[vertex] = small, large
            else:
                smallest[vertex] = min(smallest[vertex], small)
                largest[vertex] = max(largest[vertex], large)
    for vertex in range(counts.size):
        for a in range(3):
            places[vertex, a] /= counts[vertex]


@no_type_check
@numba.njit(cache=True)
def kept_near(corners, reach, places):
    """In place: no further than `reach` from the corner on any axis."""
    for vertex in range(places.shape[0]):
        for a in range(3):
            off = places[vertex, a] - corners[vertex, a]
            places[vertex, a] = corners[vertex, a] + min(max(off, -reach[vertex]), reach[vertex])


@no_type_check
@numba.njit(cache=True)
def thin(places, one, two, three):
    """Whether three places lie on a line, as those of an edge do."""
    square, longest = 0.0, 0.0
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        ub, uc = places[two, b] - places[one, b], places[two, c] - places[one, c]
        vb, vc = places[three, b] - places[one, b], places[three, c] - places[one, c]
        square += (ub * vc - uc * vb) ** 2
        longest += ub * ub + vb * vb
    return square <= THIN * THIN * longest * longest


@no_type_check
@numba.njit(cache=True)
def turns(quad):
    """Whether the corners of a square turn counter-clockwise around the third axis."""
    for s in range(4):
        t = (s + 1) % 4
        if quad[s, 0] * quad[t, 1] - quad[s, 1] * quad[t, 0] <= 0:
            return False
    return True


@no_type_check
@numba.njit(cache=True)
def chosen(starts, ring, axes, outs, low, high, places, sharp, margin, choice):
    """For each square the corner its diagonal starts from, 0 or 1, or 2 for none.

    Returns how many triangles there are, and how many squares need a vertex in their middle.

    `low` and `high` are the centres of the black and the white block. A square with more than four vertices
    has no diagonal, nor has one whose corners do not turn around the way from one centre to the other. A
    diagonal between two vertices of `sharp` goes before a shorter one, unless it leaves a
    triangle on a line. Seen along the way from one centre to the other, squares beside blocks of unequal size
    are sheared into those of `fits`.
    """
    quad, way = np.empty((4, 3)), np.empty(3)
    triangles, centres = 0, 0
    for f in range(starts.size - 1):
        first, m = starts[f], starts[f + 1] - starts[f]
        choice[f] = 2
        if m == 4:
            axis = axes[f]
            u, v = (axis + 1) % 3, (axis + 2) % 3
            turn = 1.0 if outs[f] else -1.0
            for a in range(3):
                way[a] = high[f, a] - low[f, a]
            for s in range(4):
                vertex = ring[first + s]
                height = (places[vertex, axis] - low[f, axis]) / way[axis]
                quad[s, 0] = (places[vertex, u] - low[f, u] - height * way[u]) / abs(way[axis])
                quad[s, 1] = (places[vertex, v] - low[f, v] - height * way[v]) * turn / abs(way[axis])
                quad[s, 2] = height
            best, ridge = np.inf, False
            for s in range(2 if turns(quad) else 0):
                length = 0.0
                for a in range(3):
                    length += (places[ring[first + s], a] - places[ring[first + s + 2], a]) ** 2
                here = sharp[ring[first + s]] and sharp[ring[first + s + 2]]
                better = length < best - margin if here == ridge else here
                if better and fits(quad, s, margin):
                    a, c = ring[first + s], ring[first + s + 2]
                    if sharp[a] and sharp[c]:
                        b, d = ring[first + s + 1], ring[first + (s + 3) % 4]
                        if thin(places, a, b, c) or thin(places, a, c, d):
                            continue
                    choice[f], best, ridge = s, length, here
        if choice[f] == 2:
            triangles += m
            centres += 1
        else:
            triangles += 2
    return triangles, centres


@no_type_check
@numba.njit(cache=True)
def bent_triangles(starts, ring, crossings, choice, centre, places, triangles):
    """Two triangles for a square with a diagonal, else a fan round its crossing, from `centre` on."""
    t = 0
    for f in range(starts.size - 1):
        first, m, s = starts[f], starts[f + 1] - starts[f], choice[f]
        if s < 2:
            a, c = ring[first + s], ring[first + s + 2]
            triangles[t, 0], triangles[t, 1], triangles[t, 2] = a, ring[first + s + 1], c
            triangles[t + 1, 0], triangles[t + 1, 1], triangles[t + 1, 2] = a, c, ring[first + (s + 3) % 4]
            t += 2
        else:
            for a in range(3):
                places[centre, a] = crossings[f, a]
            for k in range(m):
                triangles[t, 0], triangles[t, 1] = centre, ring[first + k]
                triangles[t, 2] = ring[first + (k + 1) % m]
                t += 1
            centre += 1
