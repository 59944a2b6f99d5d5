"""Maps of behaviour, against closed forms for corner cutting and against the one-curve engine."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import automata
import fld
import ifs
from automata import parse_text
from fld.classes import named
from fld.ends import meeting
from fld.regions import CONTRACTS, CORNER, CUSP, DIVERGES, SMOOTH, classify, regions
from ifs.certificates.family import NotAffine, family
from ifs.certificates.verdicts import lyndon, short_words, verdicts

CUTTING = family("corner-cutting", "a", "b")
MAP = regions("corner-cutting", "a", "b", resolution=120)


def linear(a, b):
    """Corner cutting on the edges d0, d1 of the polygon, columns: q1 - q0 = c d0, q2 - q1 = b d0 + a d1."""
    c = 1 - a - b
    return np.array([[c, b], [0, a]]), np.array([[b, 0], [a, c]])


def closed_form(a, b):
    """Number, primed, of the region of figure 4.14, from its inequalities as corrected."""
    c = 1 - a - b
    start, last = 1 - 2 * a - b > 0, 1 - a - 2 * b > 0
    if start and last:
        return (1, False) if a > 0 and b > 0 else (2, b < 0)
    if start != last:
        return 3, last
    return (4 if c > 0 else 5), False


def borders(a, b):
    return np.array([a, b, 1 - a - b, 1 - 2 * a - b, 1 - a - 2 * b])


def test_the_five_regions_and_their_mirror_images():
    found = named(MAP)
    assert [region.number for region in found[:5]] == [1, 2, 3, 4, 5]
    places = np.stack(np.meshgrid(MAP.x, MAP.y), axis=-1).reshape(-1, 2)
    seen = set()
    for region in found:
        for mask, primed in ((region.members, False), (region.mirrored, True)):
            for a, b in places[mask]:
                if np.abs(borders(a, b)).min() > 1e-6:
                    assert closed_form(a, b) == (region.number, primed)
                    seen.add((region.number, primed))
    assert seen == {(1, False), (2, False), (2, True), (3, False), (3, True), (4, False), (5, False)}


@given(st.floats(-1, 1), st.floats(-1, 1))
@settings(deadline=None, max_examples=60)
def test_single_members_agree_with_the_closed_form(a, b):
    assume(np.abs(borders(a, b)).min() > 1e-4)
    facts = classify(CUTTING, np.array([[a, b]]))
    if facts.verdict[0] != CONTRACTS:
        return
    number, _ = closed_form(a, b)
    assert facts.joint[0] == {1: SMOOTH, 2: CUSP}.get(number, CORNER)
    assert facts.start_own[0] == (1 - 2 * a - b > 0)
    assert facts.end_own[0] == (1 - a - 2 * b > 0)
    assert facts.start_kind[0] == facts.end_kind[0] == 0
    c = 1 - a - b
    assert facts.start_flips[0] == (a < 0 or c < 0)
    assert facts.end_flips[0] == (b < 0 or c < 0)


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
@settings(deadline=None, max_examples=80)
def test_verdicts_lie_between_a_norm_and_the_eigenvalues(a, b):
    """`max(|c|, |a| + |b|)` bounds a norm of both operators; |a|, |b|, |c| are eigenvalues of one."""
    c = 1 - a - b
    verdict = classify(CUTTING, np.array([[a, b]])).verdict[0]
    if max(abs(c), abs(a) + abs(b)) < 1 - 1e-3:
        assert verdict == CONTRACTS
    if max(abs(a), abs(b), abs(c)) >= 1:
        assert verdict == DIVERGES


def test_eigenvalues_of_single_operators_do_not_suffice():
    place = np.array([[-0.7, 0.9]])
    facts = classify(CUTTING, place)
    assert facts.alone[0]
    assert facts.verdict[0] == DIVERGES
    steps = dict(zip("01", linear(*place[0]), strict=True))
    product = np.linalg.multi_dot([*(steps[k] for k in facts.words[facts.witness[0]]), np.eye(2)])
    assert np.abs(np.linalg.eigvals(product)).max() > 1
    everywhere = (MAP.facts.verdict == CONTRACTS) & ~MAP.facts.alone
    assert not everywhere.any()
    assert (MAP.facts.alone & (MAP.facts.verdict == DIVERGES)).sum() > 100


def test_every_witness_is_a_cycle_that_does_not_shrink():
    places = np.stack(np.meshgrid(MAP.x, MAP.y), axis=-1).reshape(-1, 2)
    for k in np.flatnonzero(MAP.facts.verdict == DIVERGES)[::50]:
        steps = dict(zip("01", linear(*places[k]), strict=True))
        product = np.eye(2)
        for label in MAP.facts.words[MAP.facts.witness[k]]:
            product = product @ steps[label]
        assert np.abs(np.linalg.eigvals(product)).max() >= 1 - 1e-9


def test_the_search_of_one_system_never_contradicts_the_verdicts():
    random = np.random.default_rng(4)
    places = random.uniform(-1, 1.1, (24, 2))
    facts = classify(CUTTING, places)
    assert (facts.verdict == 2).sum() <= 3
    for place, verdict in zip(places, facts.verdict, strict=True):
        values = dict(zip("ab", (Fraction(float(v)) for v in place), strict=True))
        found = ifs.convergence(ifs.shape("corner-cutting", values).system, budget=2e6).verdict
        both = {("contracts", 1), ("does not contract", 0)}
        assert (found, int(verdict)) not in both, place


@pytest.mark.parametrize(
    ("a", "b"), [("1/4", "1/4"), ("1/5", "1/3"), ("-1/6", "2/5"), ("1/8", "4/5"), ("2/5", "9/20")]
)
def test_joints_agree_with_the_behaviour_of_one_curve(a, b):
    values = {"a": Fraction(a), "b": Fraction(b)}
    found = fld.behaviour(ifs.shape("corner-cutting", values), "1 0")
    facts = classify(CUTTING, np.array([[float(values["a"]), float(values["b"])]]))
    expected = {SMOOTH: "smooth passage", CUSP: "cusp", CORNER: "corner"}[int(facts.joint[0])]
    if found.joint is not None:
        assert found.joint.startswith(expected)
    else:
        statuses = {side.status for side in (found.left, found.right) if side}
        assert statuses & {"undecided", "oscillates"}, found


def test_another_family_has_regions_too():
    """Koch's family: vertices of one point, four pieces, complex and negative eigenvalues."""
    found = regions(
        "koch-curve", "edge.0[0,1]", "edge.0[1,2]", x_range=(0, 1.2), y_range=(-0.8, 0.8), resolution=40
    )
    assert found.family.here == pytest.approx((2 / 3, 0), abs=1e-12)
    good = found.facts.verdict == CONTRACTS
    assert 0 < good.sum() < good.size
    assert not found.facts.start_own[good].any()
    covered = sum((r.members.astype(int) + r.mirrored for r in named(found)), np.zeros(good.size, int))
    assert (covered == good).all()
    assert {0, 2} <= set(found.facts.start_kind[good].tolist())
    places = np.stack(np.meshgrid(found.x, found.y), axis=-1).reshape(-1, 2)
    steps = found.family.members(places[good])
    values = np.linalg.eigvals(steps[:, 0])
    complex_ = np.abs(values.imag).max(axis=1) > 1e-6
    assert (complex_ >= (found.facts.start_kind[good] == 2)).all()


def test_members_are_those_of_the_solver():
    values = {"a": Fraction(3, 7), "b": Fraction(-2, 5)}
    system = ifs.shape("corner-cutting", values).system
    made = CUTTING.members(np.array([[3 / 7, -2 / 5]]))[0]
    assert np.abs(made - np.stack(system.states["edge"].operators)).max() < 1e-15


def test_verdicts_of_known_systems():
    turn = 0.99 * np.array([[0.0, -1.0], [1.0, 0.0]])
    shear = np.array([[0.5, 50.0], [0.0, 0.5]])
    stack = np.stack([np.stack([turn, turn]), np.stack([shear, 0.1 * np.eye(2)]), np.stack([shear, shear.T])])
    found = verdicts(stack)
    assert found.contracts.tolist() == [True, True, False]
    assert found.diverges.tolist() == [False, False, True]
    assert found.words[found.witness[2]] == (0, 1)


def test_one_word_for_each_cycle():
    words = list(lyndon(2, 6))
    assert [sum(len(word) == k for word in words) for k in range(1, 7)] == [2, 1, 2, 3, 6, 9]
    assert len({min(word[k:] + word[:k] for k in range(len(word))) for word in words}) == len(words)
    assert all((k,) in short_words(20) for k in range(20))


def test_meeting_of_directions():
    one, other = np.array([[1.0, -1, 0]]), np.array([[0.0, 1, -1]])
    pairs = [(one, 3 * one), (one, -one), (one, other), (one, np.nan * one), (0 * one, one)]
    assert [int(meeting(left, right)[0]) for left, right in pairs] == [0, 1, 2, 3, 3]


def test_what_cannot_be_mapped_is_refused():
    with pytest.raises(ValueError, match="must rise"):
        regions("corner-cutting", "a", "b", x_range=(1, -1))
    with pytest.raises(ValueError, match="resolution"):
        regions("corner-cutting", "a", "b", resolution=0)
    with pytest.raises(ValueError, match=r"edge\.0\[2,1\]|impossible"):
        regions("corner-cutting", "a", "edge.0[1,0]")
    with pytest.raises(fld.NotACurve):
        regions("doo-sabin-patch", "vertex.s[1,0]", "vertex.s[3,0]", resolution=2)
    assert issubclass(NotAffine, ValueError)


def test_a_file_without_values_or_control_points_is_mapped():
    text = """
format = "bcifs/1"
name = "Free"
shape = "edge"
[cells.vertex]
points = 2
subdivision = { s = "vertex" }
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0, 1] }, right = { cell = "vertex", points = [1, 2] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
"""
    found = regions(parse_text(text), "a", "b", resolution=120)
    assert found.family.here is None
    assert (found.facts.joint == MAP.facts.joint).all()
    assert automata.read("corner-cutting").control is not None
