"""The diagonals of a square: a triangle stays in the envelope, or the square becomes a fan."""

import itertools

import numpy as np
import pytest
from dense.triangulate import MARGIN, Polygons, _choose, _safe, triangulate
from hypothesis import given, settings
from hypothesis import strategies as st

QUADRANTS = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])  # counter-clockwise around the axis
SHARES = np.array([w for w in itertools.product(range(13), repeat=3) if sum(w) == 12]) / 12
# corners lie a little within the cells around the axis, as means of crossings do
share = st.floats(0.02, 0.98)
rings = st.lists(st.tuples(share, share, share), min_size=4, max_size=4).map(
    lambda rows: np.array([[q[0] * r[0], q[1] * r[1], r[2]] for q, r in zip(QUADRANTS, rows, strict=True)])
)


def outside(ring: np.ndarray, corners: tuple[int, int, int]) -> float:
    """How far, in barycentric coordinates, a triangle leaves the four tetrahedra around the axis."""
    places = SHARES @ ring[list(corners)]
    depth = np.full(len(places), -np.inf)
    for s in range(4):
        tetrahedron = np.array([[0.0, 0, 0], [0, 0, 1], ring[s], ring[(s + 1) % 4]])
        system = np.vstack([tetrahedron.T, np.ones(4)])
        weights = np.linalg.solve(system, np.vstack([places.T, np.ones(len(places))]))
        depth = np.maximum(depth, weights.min(axis=0))
    return float(-depth.min())


@settings(max_examples=150, deadline=None)
@given(ring=rings, start=st.sampled_from([0, 1]))
def test_a_safe_diagonal_keeps_both_triangles_in_the_envelope(ring, start) -> None:
    halves = [(start, start + 1, (start + 2) % 4), (start, (start + 2) % 4, (start + 3) % 4)]
    worst = max(outside(ring, half) for half in halves)
    if _safe(ring, start, MARGIN):
        assert worst <= 1e-4
    else:
        # the samples may miss a small excursion, but not find one that is not there
        assert worst > -1e-9


@pytest.mark.parametrize(
    ("ring", "safe"),
    [
        # flat: both
        ([[-0.5, -0.5, 0.5], [0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]], (True, True)),
        # a dart in the plane: the diagonal that leaves it is not safe
        ([[-0.9, -0.9, 0.5], [0.9, -0.1, 0.5], [0.05, 0.05, 0.5], [-0.1, 0.9, 0.5]], (True, False)),
    ],
)
def test_known_squares(ring, safe) -> None:
    corners = np.array(ring)
    assert tuple(bool(_safe(corners, s, MARGIN)) for s in (0, 1)) == safe


def unsafe_ring() -> np.ndarray:
    """The first square at random for which neither diagonal will do."""
    rng = np.random.default_rng(0)
    while True:
        ring = np.column_stack([QUADRANTS * rng.uniform(0.02, 0.98, (4, 2)), rng.uniform(0.02, 0.98, 4)])
        if not _safe(ring, 0, MARGIN) and not _safe(ring, 1, MARGIN):
            return ring


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("out", [1, -1])
def test_a_square_without_safe_diagonal_becomes_a_fan(axis, out) -> None:
    ring = unsafe_ring()
    halves = ((0, 1, 2), (0, 2, 3)), ((1, 2, 3), (1, 3, 0))
    assert min(max(outside(ring, half) for half in pair) for pair in halves) > 0
    vertices = np.zeros((4, 3))
    vertices[:, (axis + 1) % 3], vertices[:, (axis + 2) % 3] = ring[:, 0], ring[:, 1] * out
    vertices[:, axis] = ring[:, 2] * out
    squares, inner = np.arange(4)[None], np.zeros((1, 3))
    normals = np.zeros((1, 3), dtype=np.int64)
    normals[0, axis] = out
    assert _choose(vertices, squares, inner, normals, MARGIN).tolist() == [2]
    crossing = 0.4 * normals.astype(float)
    polygons = Polygons(vertices, squares, crossing, inner, normals, np.zeros(4, dtype=np.uint8))
    points, faces = triangulate(polygons, None, np.zeros((0, 3)))
    assert np.array_equal(points, np.vstack([vertices, crossing]))
    assert faces.tolist() == [[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 3, 0]]
