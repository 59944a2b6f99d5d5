"""Boxes against attractors: known hulls, linear programs, points of the chaos game."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from ifs.certificates.bounds import Box, bounds, extent, sample
from ifs.certificates.convergence import convergence
from ifs.error import EmptyAttractor, NotContracting
from ifs.pieces import pieces
from ifs.system import State, System


def affine(linear, shift):
    """The operator on barycentric columns (1 - sum x, x...) of the map x -> linear x + shift."""
    linear, shift = np.asarray(linear, float), np.asarray(shift, float)
    size = linear.shape[1]
    moved = linear @ np.column_stack([np.zeros(size), np.eye(size)]) + shift[:, None]
    return np.vstack([1 - moved.sum(axis=0), moved])


def alone(*operators):
    labels = tuple(str(k) for k in range(len(operators)))
    state = State("x", len(operators[0]), labels, ("x",) * len(labels), tuple(operators))
    return System("x", {"x": state})


def sierpinski():
    return alone(*(affine(np.eye(2) / 2, t) for t in ([0, 0], [0.5, 0], [0, 0.5])))


def menger():
    corners = [t for t in itertools.product(range(3), repeat=3) if sum(c == 1 for c in t) < 2]
    return alone(*(affine(np.eye(3) / 3, np.array(t) / 3) for t in corners))


def koch():
    """Control points: the two ends and the tip, whose triangle is the hull of the curve."""
    tip = 0.5 + 1j * np.sqrt(3) / 6
    hull = np.array([0, 1, tip], dtype=np.complex128)
    corners = np.array([np.real(hull), np.imag(hull), np.ones(3)])
    turn = np.exp(1j * np.pi / 3) / 3
    operators = []
    for start, factor in ((0, 1 / 3), (1 / 3, turn), (tip, turn.conjugate()), (2 / 3, 1 / 3)):
        moved = start + factor * hull
        operators.append(np.linalg.solve(corners, [np.real(moved), np.imag(moved), np.ones(3)]))
    return alone(*operators), np.column_stack([np.real(hull), np.imag(hull)])


def random_system(seed):
    """Cells of 3, 4 and 2 points, with negative entries; the last leads to itself alone."""
    sizes = {"x": 3, "y": 4, "z": 2}
    arrows = {"x": ("x", "y", "z"), "y": ("y", "x"), "z": ("z", "z")}

    def scaled(scale):
        rng = np.random.default_rng(seed)
        states = {}
        for name, targets in arrows.items():
            labels = tuple(str(k) for k in range(len(targets)))
            operators = tuple(
                affine(
                    rng.normal(size=(sizes[name] - 1, sizes[target] - 1)) * scale,
                    rng.normal(size=sizes[name] - 1),
                )
                for target in targets
            )
            states[name] = State(name, sizes[name], labels, targets, operators)
        return System("x", states)

    # Linear parts 0.8 / lower times larger have a radius between 0.8 and 0.9.
    return scaled(0.01 * 0.8 / convergence(scaled(0.01), tolerance=5e-4).lower)


def chaos(system, count, seed):
    """Points of every attractor: columns carried along random paths, read backwards.

    All cells advance together: each takes a random one of its subdivisions, of a random earlier
    point of the target's.
    """
    rng = np.random.default_rng(seed)
    start = sample(system)
    points = {name: np.repeat(start[name][None], count, axis=0) for name in system.states}
    for _ in range(15):
        moved = {}
        for name, state in system.states.items():
            choice = rng.integers(len(state.labels), size=count)
            new = np.empty((count, state.points))
            for k, (target, operator) in enumerate(zip(state.targets, state.operators, strict=True)):
                own = choice == k
                earlier = rng.integers(count, size=int(own.sum()))
                new[own] = points[target][earlier] @ operator.T
            moved[name] = new
        points = moved
    return points


def assert_inside(points, lo, hi):
    slack = 1e-9 * (1 + np.abs(points).max())
    assert (points >= lo - slack).all()
    assert (points <= hi + slack).all()


def covered(points, found):
    """Which points lie in the box of some piece."""
    inside = np.zeros(len(points), dtype=bool)
    for group in found:
        for lo, hi in zip(group.lo, group.hi, strict=True):
            inside |= ((points >= lo - 1e-9) & (points <= hi + 1e-9)).all(axis=1)
    return inside


def gathered(found):
    """All control points of the pieces, cell by cell, rows sorted."""
    rows = {}
    for group in found:
        rows.setdefault(group.cell, []).append(group.control.reshape(len(group.control), -1))
    joined = {cell: np.concatenate(parts) for cell, parts in rows.items()}
    return {cell: in_order(part) for cell, part in joined.items()}


def in_order(rows):
    return rows[np.lexsort(np.round(rows.T, 9))]


def test_known_attractors_get_their_exact_boxes():
    box = bounds(menger())["x"]
    np.testing.assert_allclose(box.lo, [-2, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(box.hi, [1, 1, 1, 1], atol=1e-12)
    box = bounds(sierpinski())["x"]
    assert (box.lo == 0).all()
    assert (box.hi == 1).all()
    box = bounds(koch()[0])["x"]
    np.testing.assert_allclose(box.lo, 0, atol=1e-9)
    np.testing.assert_allclose(box.hi, 1, atol=1e-9)


def test_a_chaikin_curve_is_bounded_by_its_quadratic_spline():
    operators = (
        np.array([[0.75, 0.25, 0], [0.25, 0.75, 0.75], [0, 0, 0.25]]),
        np.array([[0.25, 0, 0], [0.75, 0.75, 0.25], [0, 0.25, 0.75]]),
    )
    box = bounds(alone(*operators))["x"]
    np.testing.assert_allclose(box.lo, [0, 0.5, 0], atol=1e-9)
    np.testing.assert_allclose(box.hi, [0.5, 0.75, 0.5], atol=1e-9)


def test_rotations_keep_the_box_near_the_attractor():
    # One box after another would grow: each turn by 45 degrees times 0.9 is wider than before.
    turn = 0.9 * np.array([[1, -1], [1, 1]]) / np.sqrt(2)
    system = alone(affine(turn, [0, 0]), affine(turn, [0.1, 0]))
    points = chaos(system, 20_000, seed=1)["x"]
    box = bounds(system)["x"]
    assert_inside(points, box.lo, box.hi)
    assert ((box.hi - box.lo) <= 1.5 * np.ptp(points, axis=0)).all()


@pytest.mark.parametrize("seed", range(3))
def test_points_of_the_chaos_game_stay_inside(seed):
    system = random_system(seed)
    found = bounds(system)
    points = chaos(system, 100_000, seed)
    for name, box in found.items():
        assert_inside(points[name], box.lo, box.hi)
        np.testing.assert_allclose(points[name].sum(axis=1), 1, atol=1e-9)
    rng = np.random.default_rng(seed)
    control = rng.normal(size=(3, 2))
    placed = points["x"] @ control
    (lo,), (hi,) = extent(found["x"], control[None])
    assert_inside(placed, lo, hi)
    assert covered(placed[:30_000], pieces(system, control, depth=4)).all()
    size = 0.2 * float((hi - lo).max())
    assert covered(placed[:1500], pieces(system, control, size=size)).all()


def test_cells_that_only_lead_elsewhere_are_bounded_by_what_they_lead_to():
    # A Cantor set on [0, 1], placed by maps with negative entries, twice in a row.
    thirds = (np.array([[1, 2 / 3], [0, 1 / 3]]), np.array([[1 / 3, 0], [2 / 3, 1]]))
    states = {
        "x": State("x", 3, ("0",), ("y",), (affine([[8.0], [-40.0]], [5, 7]),)),
        "y": State("y", 2, ("0", "1"), ("z", "z"), (affine([[2.0]], [3]), affine([[1.0]], [-6]))),
        "z": State("z", 2, ("0", "1"), ("z", "z"), thirds),
    }
    found = bounds(System("x", states))
    for name, lo, hi in [("z", [0], [1]), ("y", [-6], [5]), ("x", [-43, -193], [45, 247])]:
        np.testing.assert_allclose(found[name].lo[1:], lo, atol=1e-9)
        np.testing.assert_allclose(found[name].hi[1:], hi, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_extent_solves_the_linear_programs(seed, points):
    rng = np.random.default_rng(seed)
    inside = rng.normal(size=points)
    inside += (1 - inside.sum()) / points
    box = Box(inside - rng.random(points), inside + rng.random(points))
    control = rng.normal(size=(2, points, 3)) * 10
    lo, hi = extent(box, control)
    for k, axis in itertools.product(range(2), range(3)):
        for sign, found in ((1, lo[k, axis]), (-1, hi[k, axis])):
            exact = linprog(
                sign * control[k, :, axis],
                A_eq=np.ones((1, points)),
                b_eq=[1],
                bounds=np.column_stack([box.lo, box.hi]),
            )
            assert found == pytest.approx(sign * exact.fun, abs=1e-8)
        assert lo[k, axis] <= inside @ control[k, :, axis] <= hi[k, axis]


def test_extent_keeps_far_away_points_inside():
    rng = np.random.default_rng(3)
    weights = rng.dirichlet(np.ones(4), size=200)
    box = Box(weights.min(axis=0), weights.max(axis=0))
    control = 1e6 + rng.random((5, 4, 3)) * 1e-3
    lo, hi = extent(box, control)
    exact = np.einsum("wj,cjd->cwd", weights.astype(np.longdouble), control.astype(np.longdouble))
    exact /= weights.astype(np.longdouble).sum(axis=1)[None, :, None]
    assert (exact >= lo[:, None]).all()
    assert (exact <= hi[:, None]).all()
    assert (hi - lo <= 1e-3 + 1e-7).all()


@pytest.mark.parametrize("seed", range(5))
def test_samples_satisfy_the_equation_of_the_attractor(seed):
    system = random_system(seed)
    found = sample(system)
    for name, state in system.states.items():
        np.testing.assert_allclose(found[name], state.operators[0] @ found[state.targets[0]], atol=1e-9)
        assert found[name].sum() == pytest.approx(1)


def test_systems_without_attractor_are_refused():
    grows = alone(affine([[1.5, 0], [0, 0.5]], [1, 0]), affine([[0.5, 0], [0, 0.5]], [-1, 0]))
    with pytest.raises(NotContracting):
        bounds(grows)
    with pytest.raises(NotContracting):
        pieces(grows, np.eye(3), size=0.1)
    with pytest.raises(NotContracting):
        sample(alone(np.eye(3)))
    ends = System("x", {"x": State("x", 2, (), (), ())})
    with pytest.raises(EmptyAttractor, match="'x'"):
        bounds(ends)
    with pytest.raises(EmptyAttractor, match="'x'"):
        sample(ends)


def test_pieces_of_a_depth_are_the_words_of_that_length():
    system, control = koch()
    found = gathered(pieces(system, control, depth=3))["x"]
    expected = []
    for word in itertools.product(system.states["x"].operators, repeat=3):
        product = np.linalg.multi_dot(word)
        expected.append((product.T @ control).ravel())
    expected = np.array(expected)
    np.testing.assert_allclose(found, in_order(expected), atol=1e-12)
    (whole,) = pieces(system, control, depth=0)
    np.testing.assert_array_equal(whole.control, control[None])


@pytest.mark.parametrize("chunk", [1, 7, 100_000])
def test_pieces_do_not_depend_on_the_chunk(chunk):
    system = random_system(0)
    control = np.random.default_rng(0).normal(size=(3, 3))
    whole = gathered(pieces(system, control, depth=5))
    parts = list(pieces(system, control, depth=5, chunk=chunk))
    assert all(len(part.lo) <= chunk for part in parts)
    again = gathered(parts)
    assert whole.keys() == again.keys()
    for cell, rows in whole.items():
        np.testing.assert_allclose(again[cell], rows, atol=1e-12)
    repeated = pieces(system, control, depth=5, chunk=chunk)
    for one, other in zip(parts, repeated, strict=True):
        np.testing.assert_array_equal(one.control, other.control)


def test_pieces_of_a_size_stop_as_soon_as_they_fit():
    control = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])
    found = list(pieces(menger(), control, size=1.000001))
    assert sum(len(group.lo) for group in found) == 20**2
    sides = np.concatenate([group.hi - group.lo for group in found])
    np.testing.assert_allclose(sides, 1, atol=1e-9)
    corners = np.round(np.concatenate([group.lo for group in found]))
    assert len(np.unique(corners, axis=0)) == 20**2


def test_skipped_pieces_are_left_out_with_all_that_is_in_them():
    control = np.array([[0.0, 0], [8, 0], [0, 8]])
    found = list(pieces(sierpinski(), control, size=1.0001, skip=lambda lo, hi: lo[:, 0] >= 4))
    assert sum(len(group.lo) for group in found) == 3**3 - 3**2
    assert max(group.lo[:, 0].max() for group in found) < 4


def test_the_first_pieces_of_a_great_depth_come_at_once():
    # 3^35 pieces in all: a generation at a time would never arrive.
    control = np.array([[0.0, 0], [1, 0], [0, 1]])
    first = next(pieces(sierpinski(), control, depth=35, chunk=64))
    assert len(first.lo) <= 64
    np.testing.assert_allclose(first.hi - first.lo, 0.5**35, rtol=1e-4)


def test_an_attractor_that_is_one_point_ends():
    shrink = alone(affine([[0.5, 0.2], [-0.2, 0.5]], [0.3, 0.1]))
    control = np.array([[0.0, 0], [8, 0], [0, 8]])
    (found,) = pieces(shrink, control, size=1e-6)
    assert len(found.lo) == 1
    assert_inside(sample(shrink)["x"] @ control, found.lo[0], found.hi[0])
    point = alone(np.ones((1, 1)))
    (found,) = pieces(point, np.array([[3.0, 4.0]]), size=1e-3)
    np.testing.assert_allclose(found.lo, [[3, 4]], atol=1e-9)


def test_wrong_requests_are_refused_at_the_call():
    control = np.array([[0.0, 0], [8, 0], [0, 8]])
    for arguments, message in [
        ({}, "either a size"),
        ({"size": 1.0, "depth": 2}, "either a size"),
        ({"size": 0.0}, "above 0"),
        ({"size": 1e-13}, "above 0"),
        ({"depth": -1}, "depth is a whole number, 0 or more"),
        ({"depth": 1, "chunk": 0}, "chunk is a whole number, 1 or more"),
    ]:
        with pytest.raises(ValueError, match=message):
            pieces(sierpinski(), control, **arguments)
    with pytest.raises(ValueError, match="takes 3 control points"):
        pieces(sierpinski(), control[:2], depth=1)
