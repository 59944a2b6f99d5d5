"""Members of families chosen by eigenvalues, joints, signs and nearness, against closed forms."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import automata
import subdivision
from subdivision import WrongValue
from subdivision.choose import NotMet, _Search, choose
from subdivision.descent import freedom, in_turn
from subdivision.eigen import left_vector, rest, schur_vectors
from subdivision.joint import End, smooth_joints
from subdivision.member import differences, family
from subdivision.requests import Contracts, Eigenvalue, Eigenvector, Nearest, Positive, SymmetricMask

F = Fraction


@pytest.fixture(scope="module")
def corner():
    return subdivision.solve(automata.read("corner-cutting"))


def edge(label, value, **options):
    return Eigenvalue("edge", (label,), value, **options)


def vertex(value, times=1, **options):
    return Eigenvalue("vertex", ("s",), value, times, **options)


def numbers(choice, cell, label):
    rows = choice.solution.operators[cell][label]
    return np.array([[float(form.get(-1, 0)) for form in row] for row in rows])


def test_the_eigenvalues_of_chaikin_leave_chaikin_alone(corner):
    found = choose(corner, [edge(k, F(1, n)) for k in "01" for n in (2, 4)])
    assert found.ok
    assert found.exact == {"a": F(1, 4), "b": F(1, 4)}
    assert found.degrees_of_freedom == 0
    assert max(o.residual for o in found.outcomes) <= 1e-12
    for label in "01":
        values = np.sort(np.linalg.eigvals(numbers(found, "edge", label)).real)
        assert np.allclose(values, [1 / 4, 1 / 2, 1], atol=1e-12)


def test_one_eigenvalue_leaves_a_line_and_the_nearest_point_of_it_is_taken(corner):
    # 1 - a - b = 1/2 is a line, and (1/8, 3/8) the foot of the perpendicular from (1/4, 1/2).
    found = choose(corner, [edge("0", F(1, 2)), Nearest({"a": 0.25, "b": 0.5})])
    assert found.exact == {"a": F(1, 8), "b": F(3, 8)}
    assert found.distance == pytest.approx(2**0.5 / 8, abs=1e-12)
    assert found.degrees_of_freedom == 1


@settings(max_examples=3, deadline=None)
@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
def test_without_conditions_the_wish_itself_is_the_answer(a, b):
    found = choose(subdivision.solve(automata.read("corner-cutting")), [Nearest({"a": a, "b": b})], starts=1)
    assert found.values == pytest.approx({"a": a, "b": b}, abs=1e-12)
    assert found.degrees_of_freedom == 2


@pytest.mark.parametrize("wish", [(0.2, 0.3), (0.5, 0.2)])
def test_a_smooth_joint_lies_in_gregorys_region(corner, wish):
    near = Nearest(dict(zip("ab", wish, strict=True)))
    found = choose(corner, [*smooth_joints(corner.automaton), near])
    a, b = found.values["a"], found.values["b"]
    assert found.ok
    if wish == (0.2, 0.3):  # it is in the region: 1 - a - b > max(a, b), a, b > 0
        assert (a, b) == (0.2, 0.3)
    singular = min(abs(a), abs(b), abs(1 - a - b)) < 1e-9  # the curve is a segment
    assert singular or (min(a, b) > 0 and 1 - a - b > max(a, b))


@pytest.mark.parametrize(("a", "b"), [("1/2", "1/4"), ("-1/8", "1/4"), ("1/3", "-1/4"), ("1/8", "1/2")])
def test_corners_and_cusps_are_no_smooth_joints(corner, a, b):
    fixed = corner.with_values({"a": F(a), "b": F(b)})
    assert not choose(fixed, smooth_joints(corner.automaton)).ok


def test_the_ends_of_a_joint_are_read_from_the_automaton(corner):
    (joint,) = smooth_joints(corner.automaton)
    assert joint.left.joint == End(("0",), ("1",))
    assert joint.right.joint == End(("1",), ("0",))
    assert joint.left.far == End(("0",), ("0",))
    with pytest.raises(WrongValue, match="no joints"):
        smooth_joints(automata.read("sierpinski-triangle"))


def test_the_vertex_of_doo_and_sabin():
    family = subdivision.solve(automata.read("doo-sabin-patch"))
    found = choose(family, [vertex(F(1, 2), 2, dominant=True), vertex(F(1, 4))])
    assert found.ok
    assert found.degrees_of_freedom == 0
    column = [form.get(-1, 0) for (form, *_) in found.solution.operators["vertex"]["s"]]
    assert column == [F(9, 16), F(3, 16), F(3, 16), F(1, 16)]


def test_the_vertex_of_catmull_and_clark():
    family = subdivision.solve(automata.read("catmull-clark-patch"))
    near = Nearest({key: float(value) + 0.004 for key, value in family.automaton.values.items()})
    spectrum = [vertex(F(1, 2), 2, dominant=True), vertex(F(1, 4), 3), vertex(F(1, 8), 2), vertex(F(1, 16))]
    found = choose(family, [*spectrum, near], starts=4)
    assert found.ok
    assert found.degrees_of_freedom == 0
    assert found.solution.operators == family.with_values(family.automaton.values).operators


def test_an_impossible_request_is_reported_with_its_distance(corner):
    fixed = corner.with_values({"a": F(1, 4), "b": F(1, 4)})
    wrong = vertex(F(1, 3))  # the only eigenvalue on differences is 1/2
    found = choose(fixed, [wrong, edge("0", F(1, 4))])
    assert [o.met for o in found.outcomes] == [False, True]
    assert found.unmet[0].residual == pytest.approx(1 / 6, abs=1e-12)
    with pytest.raises(NotMet, match=r"off by 0\.167") as caught:
        choose(fixed, [wrong], throw=True)
    assert caught.value.choice.unmet[0].request == wrong


def test_of_requests_that_exclude_each_other_the_earlier_is_kept(corner):
    found = choose(corner, [vertex(F(1, 3)), vertex(F(1, 2))], starts=2)
    assert [o.met for o in found.outcomes] == [True, False]
    assert found.values["a"] + found.values["b"] == pytest.approx(2 / 3, abs=1e-12)
    assert found.degrees_of_freedom == 1


def test_signs_symmetry_and_eigenvectors(corner):
    positive = choose(corner, [Positive(margin=F(1, 10)), Nearest({"a": -1, "b": 0.3})])
    assert positive.exact == {"a": F(1, 10), "b": F(3, 10)}
    mirror = SymmetricMask("edge", "0", (2, 1, 0), image="1")  # a = b
    both = choose(corner, [mirror, Contracts(longest=1), Nearest({"a": 0.1, "b": 0.3})])
    assert both.exact == {"a": F(1, 5), "b": F(1, 5)}
    assert both.degrees_of_freedom == 1
    # The fixed point of T_0 is (b, a, 0)/(a + b): a = 2b, whose nearest point to (0.3, 0.3) is (9, 4.5)/25.
    point = Eigenvector("edge", ("0",), (F(1, 3), F(2, 3), 0))
    assert choose(corner, [point, Nearest({"a": 0.3, "b": 0.3})]).exact == {"a": F(9, 25), "b": F(9, 50)}


def test_all_constraints_hold_exactly_at_doubles_that_are_no_small_fractions(corner):
    found = choose(corner, [edge("0", 2**-0.5), Nearest({"a": 0.1, "b": 0.2})])
    assert found.ok
    assert found.values["a"] + found.values["b"] == pytest.approx(1 - 2**-0.5, abs=1e-12)
    for table in found.solution.operators.values():
        for rows in table.values():
            assert all(sum(form.get(-1, 0) for form in column) == 1 for column in zip(*rows, strict=True))
    again = choose(corner, [edge("0", 2**-0.5), Nearest({"a": 0.1, "b": 0.2})])
    assert again.exact == found.exact


def test_eigenvalues_in_a_jordan_block_are_met_to_full_precision(corner):
    # a = 1 - a - b = 1/3: T_0 has a double eigenvalue with one eigenvector.
    found = choose(corner, [edge("0", F(1, 3), multiplicity=2)])
    # b is a simple root of the trace; a a double root of the determinant, (a - 1/3)^2 = 0.
    assert found.exact["b"] == F(1, 3)
    assert found.values["a"] == pytest.approx(1 / 3, abs=1e-6)
    assert found.outcomes[0].residual <= 1e-12


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (Eigenvalue("egde", ("0",), 1), "did you mean 'edge'"),
        (Eigenvalue("edge", ("2",), 1), "stops at its label 1"),
        (Eigenvalue("edge", ("0", "left"), 1), "returns to its cell"),
        (Eigenvalue("edge", ("0",), 1, 3), "2 eigenvalues"),
        (Eigenvector("edge", ("0",), (1, 2)), "3 coordinates"),
        (SymmetricMask("edge", "0", (0, 0, 1)), "no permutation"),
        (Nearest({"z": 1}), "'z'"),
        (Nearest({"a": 1}, {"a": -1}), "positive weights"),
    ],
)
def test_requests_that_do_not_fit_are_refused(corner, request_, message):
    with pytest.raises(WrongValue, match=message):
        choose(corner, [request_])


def test_a_member_is_the_exact_one(corner):
    member = family(corner).at(np.array([1 / 5, 1 / 3]), np)
    a, b = 1 / 5, 1 / 3
    assert np.allclose(member.operator("edge", "0"), [[1 - a, b, 0], [a, 1 - b, 1 - a], [0, 0, a]])
    assert np.allclose(sorted(np.linalg.eigvals(member.linear("edge", ("1",)))), [b, 1 - a - b])
    assert np.allclose(member.fixed_point("edge", ("0",)), np.array([b, a, 0]) / (a + b))


def test_eigenvectors_and_what_is_left():
    random = np.random.default_rng(5)
    basis = random.standard_normal((4, 4))
    matrix = basis @ np.diag([0.9, 0.5, 0.5, -0.2]) @ np.linalg.inv(basis)
    vectors = schur_vectors(matrix - 0.5 * np.eye(4), 2)
    assert np.allclose(matrix @ vectors, vectors @ (vectors.T @ matrix @ vectors), atol=1e-12)
    left = sorted(np.linalg.eigvals(rest(matrix, vectors, np)).real)
    assert np.allclose(left, [-0.2, 0, 0, 0.9], atol=1e-10)
    unit = basis[:, 0] / np.linalg.norm(basis[:, 0])
    row = left_vector(matrix, 0.9, unit, np)
    assert np.allclose(row @ matrix, 0.9 * row)
    assert row @ unit == pytest.approx(1)
    assert np.allclose(differences(5).T @ differences(5), np.eye(4))
    assert np.allclose(differences(5).sum(axis=0), 0)


def test_levels_and_freedom():
    step = in_turn(
        [(np.array([[1.0, 1.0, 0.0]]), np.array([2.0])), (np.eye(3), np.array([3.0, 0.0, 7.0]))], 3
    )
    assert np.allclose(step, [2.5, -0.5, 7])
    # x + z = 0 and x - y = 0: with z eliminated one of (x, y) is free.
    assert freedom(np.array([[1.0, 0, 1], [1, -1, 0]]), 2) == 1


def test_what_is_compiled_for_all_requests_serves_some_of_them():
    own = family(subdivision.solve(automata.read("corner-cutting")))
    half, quarter = (Eigenvalue("edge", ("0",), Fraction(1, k)) for k in (2, 4))
    other = Eigenvalue("edge", ("1",), Fraction(1, 3), 1, True)
    search = _Search(own, (), 0, 1, (half, other, quarter))
    for some in ((other,), (half, quarter)):
        y = search.first(some)[0] + 0.01
        part, alone = search.problem(some), _Search(own, (), 0, 1, some).problem(some)
        assert part.within is not None
        assert alone.within is None
        for found, expected in zip(part.at(y), alone.at(y), strict=True):
            assert np.allclose(found, expected, atol=1e-12)
