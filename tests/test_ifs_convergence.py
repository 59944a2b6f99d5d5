"""Joint spectral radii that are known, and brute force where they are not."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs.certificates.convergence import convergence, require_contraction
from ifs.certificates.differences import components, linear_part, spectral_norm, spectral_radius, steps
from ifs.error import NotContracting, Undecided
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


def linear_system(*linears):
    return alone(*(affine(linear, np.zeros(len(linear))) for linear in linears))


def graph(arrows):
    """A system from (cell, label, target, linear part) with sizes read off the linear parts."""
    rows = {}
    for cell, label, target, linear in arrows:
        linear = np.asarray(linear, float)
        operator = affine(linear, np.full(linear.shape[0], 0.25))
        rows.setdefault(cell, []).append((label, target, operator))
    states = {
        cell: State(cell, len(row[0][2]), *(tuple(column) for column in zip(*row, strict=True)))
        for cell, row in rows.items()
    }
    return System(arrows[0][0], states)


def paths(system, length):
    """Every path of that length as (start, end, labels, product of linear parts)."""
    found = [(name, name, (), np.eye(state.points - 1)) for name, state in system.states.items()]
    for _ in range(length):
        found = [
            (start, target, (*word, label), product @ linear_part(operator))
            for start, end, word, product in found
            for label, target, operator in zip(
                system.states[end].labels,
                system.states[end].targets,
                system.states[end].operators,
                strict=True,
            )
        ]
    return found


def corner_cutting(a, b):
    return alone(
        np.array([[1 - a, b, 0], [a, 1 - b, 1 - a], [0, 0, a]]),
        np.array([[b, 0, 0], [1 - b, 1 - a, b], [0, a, 1 - b]]),
    )


def menger():
    corners = [t for t in itertools.product(range(3), repeat=3) if sum(c == 1 for c in t) < 2]
    return alone(*(affine(np.eye(3) / 3, np.array(t) / 3) for t in corners))


def random_system(seed):
    """Two cells of 3 and 4 points that lead to themselves and to each other."""
    rng = np.random.default_rng(seed)
    arrows = [
        (cell, label, target, rng.normal(size=(rows, columns)) * 0.35)
        for cell, rows, label, target, columns in [
            ("x", 2, "a", "x", 2),
            ("x", 2, "b", "y", 3),
            ("y", 3, "c", "x", 2),
            ("y", 3, "d", "y", 3),
        ]
    ]
    return graph(arrows)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.02, 0.97), st.floats(0.02, 0.97))
def test_corner_cutting_contracts_by_its_difference_scheme(a, b):
    # On p1 - p0, p2 - p1 the operators have the largest row sums 1 - a - b and a + b, and the
    # eigenvalues 1 - a - b, a, b: where the former is larger, nothing is left to search.
    if a + b > 1:
        a, b = 1 - a, 1 - b
    found = convergence(corner_cutting(a, b), tolerance=1e-2)
    assert found.lower >= max(a, b, 1 - a - b) - 1e-12
    assert found.lower <= max(a + b, 1 - a - b) + 1e-12
    assert found.upper <= found.lower + 1.01e-2 or a + b > 0.9
    if a + b < 0.5:
        assert found.lower == pytest.approx(1 - a - b, abs=1e-12)
        assert found.verdict == "contracts"


@pytest.mark.parametrize(("a", "b"), [(1.0, 0.3), (-0.1, 0.05), (0.5, 1.2), (-0.2, 0.2)])
def test_corner_cutting_outside_its_range_does_not_contract(a, b):
    with pytest.raises(NotContracting) as caught:
        require_contraction(corner_cutting(a, b))
    expected = max(abs(a), abs(b), abs(1 - a - b))
    assert caught.value.cell == "x"
    assert caught.value.radius ** (1 / len(caught.value.word)) >= expected - 1e-12
    assert all(f"'{caught.value.cell}'" in str(caught.value) for _ in caught.value.word)


def test_the_golden_pair():
    golden = (1 + np.sqrt(5)) / 2
    found = convergence(linear_system([[0.5, 0.5], [0, 0.5]], [[0.5, 0], [0.5, 0.5]]))
    assert found.lower == pytest.approx(golden / 2, abs=1e-13)
    assert sorted(found.word) == ["0", "1"]
    assert golden / 2 <= found.upper <= golden / 2 + 1.01e-3


@pytest.mark.parametrize("product", [1.0, 4.0])
def test_maps_that_shrink_alone_but_not_together(product):
    step = np.sqrt(product)
    system = linear_system([[0.5, step], [0, 0.5]], [[0.5, 0], [step, 0.5]])
    for state in system.states.values():
        for operator in state.operators:
            assert convergence(alone(operator)).verdict == "contracts"
    with pytest.raises(NotContracting) as caught:
        require_contraction(system)
    assert len(caught.value.word) == 2
    exact = np.abs(np.linalg.eigvals(np.array([[0.5, step], [0, 0.5]]) @ [[0.5, 0], [step, 0.5]])).max()
    assert caught.value.radius == pytest.approx(exact, rel=1e-13)


def test_a_radius_of_exactly_one_is_no_contraction():
    found = convergence(linear_system([[0, 1], [0, 0]], [[0, 0], [1, 0]]))
    assert (found.verdict, len(found.word), found.lower) == ("does not contract", 2, 1.0)
    rotation = [[0.6, -0.8], [0.8, 0.6]]
    assert convergence(linear_system(rotation)).verdict == "does not contract"
    just_below = np.array(rotation) * (1 - 1e-9)
    assert convergence(linear_system(just_below)).verdict == "contracts"


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.floats(-2, 2), min_size=2, max_size=2),
    st.lists(st.floats(-2, 2), min_size=4, max_size=4),
)
def test_cycles_through_cells_of_different_sizes(up, down):
    # Every cycle x -> y -> x is a product of numbers, so the radius is known.
    up, down = np.array(up).reshape(2, 1), np.array(down).reshape(2, 1, 2)
    system = graph([("x", "u", "y", up), ("y", "p", "x", down[:1, 0]), ("y", "q", "x", down[1:, 0])])
    exact = np.sqrt(max(abs((row @ up).item()) for row in down))
    found = convergence(system)
    # Near 0 the root makes 1e-7 of the rounding in the operators' own columns. No ellipsoid is the
    # unit ball of a best norm here, so that the upper end comes from long words.
    assert found.lower <= exact + 1e-6 <= found.upper + 2e-6
    if 0.01 < exact < 0.94:
        assert found.lower == pytest.approx(exact, rel=1e-9)
        assert found.upper <= 1.05 * exact
        assert found.verdict == "contracts"
    if exact >= 1:
        assert found.verdict == "does not contract"


def test_only_paths_of_the_automaton_count():
    # A free product of a and b grows, but b only leads out of the cell that a stays in.
    arrows = [
        ("x", "a", "x", [[0.5, 0], [3, 0.5]]),
        ("x", "b", "y", [[0.4, 50], [0, 0.4]]),
        ("y", "c", "y", [[0.25, 7], [0, 0.25]]),
    ]
    found = convergence(graph(arrows))
    assert [part.cells for part in found.components] == [("y",), ("x",)]
    assert found.components[0].lower == pytest.approx(0.25, abs=1e-12)
    assert found.components[0].upper == pytest.approx(0.25, abs=3e-3)
    assert (found.lower, found.upper) == (pytest.approx(0.5), pytest.approx(0.5, abs=1e-2))
    assert (found.cell, found.word) == ("x", ("a",))
    free = linear_system([[0.5, 0], [3, 0.5]], [[0.4, 50], [0, 0.4]])
    assert convergence(free).verdict == "does not contract"


def test_components_stand_after_what_they_lead_to():
    one = [[0.5]]
    arrows = [("a", "0", "b", one), ("b", "1", "c", one), ("c", "2", "b", one), ("c", "3", "d", one)]
    found = components(graph([*arrows, ("d", "4", "d", one), ("e", "5", "a", one)]))
    assert found == (("d",), ("b", "c"), ("a",), ("e",))


def test_cells_of_one_point_contract_at_once():
    system = graph([("x", "0", "x", [[0.5]]), ("x", "1", "p", np.zeros((1, 0)))])
    point = State("p", 1, ("s",), ("p",), (np.ones((1, 1)),))
    found = convergence(System("x", {**system.states, "p": point}))
    assert [part.upper for part in found.components if part.cells == ("p",)] == [0.0]
    assert found.upper == pytest.approx(0.5, abs=1e-9)


def test_equal_linear_parts_are_decided_by_words_of_one_letter():
    found = convergence(menger())
    assert found.lower == pytest.approx(1 / 3, abs=1e-12)
    assert found.upper == pytest.approx(1 / 3, abs=1e-12)
    assert found.components[0].depth == 1
    assert len(steps(menger(), ("x",))) == 1


@pytest.mark.parametrize("seed", range(6))
def test_brute_force_agrees_and_the_certificate_holds(seed):
    system = random_system(seed)
    found = convergence(system, tolerance=1e-2)
    (part,) = found.components
    for length in range(1, 8):
        norms = []
        for start, end, _, product in paths(system, length):
            size = product.shape
            if start == end:
                assert np.abs(np.linalg.eigvals(product)).max() ** (1 / length) <= found.upper
            normed = part.factors[start] @ product @ np.linalg.inv(part.factors[end])
            norms.append(np.linalg.norm(normed, 2))
            assert size == normed.shape
        assert max(norms) <= part.constant * part.rate**length * (1 + 1e-9)
        assert max(norms) ** (1 / length) >= found.lower * (1 - 1e-9)
    assert found.cell is not None
    product = np.eye(system.states[found.cell].points - 1)
    cell = found.cell
    for label in found.word:
        state = system.states[cell]
        k = state.labels.index(label)
        product, cell = product @ linear_part(state.operators[k]), state.targets[k]
    assert cell == found.cell
    radius = np.abs(np.linalg.eigvals(product)).max()
    assert radius ** (1 / len(found.word)) == pytest.approx(found.lower, rel=1e-9)


def test_a_budget_too_small_says_so():
    rng = np.random.default_rng(8)
    linears = rng.normal(size=(3, 3, 3))
    linears *= 0.9999 / convergence(linear_system(*linears)).lower
    with pytest.raises(Undecided) as caught:
        require_contraction(linear_system(*linears), budget=1.0)
    assert caught.value.lower < 1 <= caught.value.upper
    assert "budget" in str(caught.value)


def test_spectral_radius_of_jordan_blocks():
    # Unimodular, so that the conjugated block has exact integers over 4.
    change = np.array([[1, 2, 3], [0, 1, 4], [0, 0, 1]]) @ np.array([[1, 0, 0], [5, 1, 0], [6, 7, 1]])
    inverse = np.round(np.linalg.inv(change))
    assert (change @ inverse == np.eye(3)).all()
    block = np.array([[3, 4, 0], [0, 3, 4], [0, 0, 3]]) / 4
    matrix = change @ block @ inverse
    assert abs(np.abs(np.linalg.eigvals(matrix)).max() - 0.75) > 1e-7
    assert spectral_radius(matrix) == pytest.approx(0.75, abs=1e-10)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 6))
def test_spectral_norm_is_the_largest_singular_value(seed, rows, columns):
    matrices = np.random.default_rng(seed).normal(size=(5, rows, columns))
    expected = np.linalg.svd(matrices, compute_uv=False)[:, 0]
    np.testing.assert_allclose(spectral_norm(matrices), expected, rtol=1e-13)
