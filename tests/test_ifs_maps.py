"""Maps, plain and restricted IFS, the chaos game and pieces in chunks."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from scipy.spatial import KDTree

import ifs
from automata import AutomatonError
from automata.fractint import fractint_ifs
from automata.language import forbidding, restricted
from automata.turtle import lsystem_automaton
from ifs.dimensions.dimension import similarity_dimension
from ifs.maps.homogeneous import NoContraction, contraction, projective_points
from ifs.maps.maps import Map, affine, projective, similarity
from ifs.maps.plain import from_maps, maps_of
from ifs.measures.moments import WrongProbabilities, moments
from ifs.orbits.attractor import pieces_in_chunks, points_in_chunks
from ifs.orbits.chaos import _alias, given_weights, points, weights
from ifs.orbits.walk import _next

FERN = """fern {
  0    0    0    .16 0 0   .01
  .85  .04 -.04  .85 0 1.6 .85
  .2  -.26  .23  .22 0 1.6 .07
 -.15  .28  .26  .24 0 .44 .07 }"""
DRAGON = "D { Angle 8\n Axiom F\n F=-F++G-\n G=+F--G+ }"
THIRD = Fraction(1, 3)
CANTOR = [affine([[THIRD]], [0]), affine([[THIRD]], [2 * THIRD])]
HALVES = [affine([[Fraction(1, 2)]], [0]), affine([[Fraction(1, 2)]], [Fraction(1, 2)])]


def some_map(rng, dimension, last=True):
    rows = [[Fraction(int(x), 7) for x in row] for row in rng.integers(-9, 10, (dimension + 1,) * 2)]
    rows[-1] = rows[-1] if last else [Fraction(0)] * dimension + [Fraction(1)]
    for i in range(dimension + 1):
        rows[i][i] += 5
    return projective(rows)


@pytest.mark.parametrize("dimension", [1, 2, 3, 5])
@pytest.mark.parametrize("last", [True, False])
def test_composition_and_inverse(dimension, last):
    rng = np.random.default_rng(dimension)
    for _ in range(5):
        f, g, h = (some_map(rng, dimension, last) for _ in range(3))
        x = rng.normal(size=(20, dimension)) / 20
        assert np.abs(f.compose(g).apply(x) - f.apply(g.apply(x))).max() < 1e-9
        assert np.abs(f.inverse().apply(f.apply(x)) - x).max() < 1e-9
        one = f.compose(g.compose(h)).rows
        other = f.compose(g).compose(h).rows
        assert one == other  # associative, exactly
        unit = f.compose(f.inverse()).rows
        assert all((entry == unit[0][0]) == (i == j) for i, r in enumerate(unit) for j, entry in enumerate(r))


def test_similarities_multiply_distances():
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    made = [
        similarity(0.5, [1, 2], angle=33, mirror=True),
        similarity(2, [0, 0], angle=-90),
        similarity(0.25, [1, 0, 0, 2], rotation=turn.tolist()),
    ]
    for f, factor in zip(made, (0.5, 2, 0.25), strict=True):
        x, y = rng.normal(size=(2, 30, f.dimension))
        before, after = (np.linalg.norm(a - b, axis=1) for a, b in ((x, y), (f.apply(x), f.apply(y))))
        assert np.allclose(after, factor * before, rtol=1e-12)
        assert f.ratio() == pytest.approx(factor)
        assert f.lipschitz() == pytest.approx(factor)
    assert np.linalg.det(made[0].linear) < 0
    assert affine([[1, 0], [0, 2]], [0, 0]).ratio() is None


def test_lipschitz_constants_hold_and_those_of_affine_maps_are_attained():
    rng = np.random.default_rng(2)
    for dimension in (1, 2, 3):
        f = some_map(rng, dimension, last=False)
        x, y = rng.normal(size=(2, 5000, dimension))
        slopes = np.linalg.norm(f.apply(x) - f.apply(y), axis=1) / np.linalg.norm(x - y, axis=1)
        assert 0.9 * f.lipschitz() < slopes.max() <= f.lipschitz() * (1 + 1e-12)
        g = some_map(rng, dimension)
        lo, hi = [-0.2] * dimension, [0.3] * dimension
        x, y = rng.uniform(-0.2, 0.3, size=(2, 5000, dimension))
        slopes = np.linalg.norm(g.apply(x) - g.apply(y), axis=1) / np.linalg.norm(x - y, axis=1)
        assert slopes.max() <= g.lipschitz(lo, hi) < 6 * slopes.max()
        low, high = g.image_box(lo, hi)
        assert (low <= g.apply(x) + 1e-12).all()
        assert (g.apply(x) <= high + 1e-12).all()


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda: affine([[1, 2], [3]], [0, 0]), "row 1 has 2 numbers, expected 3"),
        (lambda: affine([[1]], [0, 0]), "expected 2 rows"),
        (lambda: affine([[math.inf]], [0]), "row 0 of a map is a finite number, found inf"),
        (lambda: projective([[1, 0], [0, 0]]), "last row of the matrix is 0"),
        (lambda: similarity(0, [0, 0]), "above 0, found 0"),
        (lambda: similarity(1, [0, 0, 0], angle=3), "an angle turns the plane"),
        (lambda: similarity(1, [0, 0], rotation=[[1, 1], [0, 1]]), "orthogonal"),
        (lambda: affine([[0]], [1]).inverse(), "no inverse"),
        (lambda: projective([[1, 0], [1, 1]]).lipschitz(), "give the box"),
        (lambda: projective([[1, 0], [1, 0]]).lipschitz([-1], [1]), "to infinity"),
        (
            lambda: projective([[1, 0], [1, -2]]).apply(np.array([[1.0], [2.0]])),
            "point 1, .* goes to infinity",
        ),
        (lambda: projective([[1, 0], [1, 1]]).linear, "projective map has no linear part"),
        (lambda: from_maps([CANTOR[0], projective([[1, 0], [1, 1]])]), "map 1 is projective"),
        (lambda: from_maps([CANTOR[0], affine([[1, 0], [0, 1]], [0, 0])]), "map 1 is no map of R.1"),
        (lambda: from_maps([]), "1 to 4096 maps"),
    ],
)
def test_wrong_maps_are_named(action, words):
    with pytest.raises(ValueError, match=words):
        action()


def test_maps_come_back_from_their_automaton_exactly():
    rng = np.random.default_rng(5)
    for dimension in (1, 2, 3):
        made = [some_map(rng, dimension, last=False) for _ in range(4)]
        assert maps_of(ifs.shape(from_maps(made))) == made
    sponge = maps_of(ifs.shape("menger-sponge"))
    assert len(sponge) == 20
    assert [f.ratio() for f in sponge] == pytest.approx([1 / 3] * 20)
    assert sponge[-1].translation == pytest.approx([36, 36, 36])


def test_shapes_that_are_no_plain_ifs_are_refused():
    with pytest.raises(ValueError, match="sub-cell '1' of 'F' is a 'G'"):
        maps_of(ifs.shape(lsystem_automaton(DRAGON)))
    with pytest.raises(ValueError, match=r"no frame of R\^1"):
        maps_of(ifs.shape("koch-curve", control=np.array([[0], [1], [2]])))


def test_a_projective_ifs_is_the_projective_image_of_an_affine_one():
    g = projective([[3, 0, 1], [0, 2, 0], [1, 1, 4]])
    half = Fraction(1, 2)
    triangle = [similarity(half, place) for place in ([0, 0], [half, 0], [0, half])]
    moved = [g.compose(f).compose(g.inverse()) for f in triangle]
    assert not moved[0].is_affine or not moved[1].is_affine
    lo, hi = g.image_box([0, 0], [1, 1])
    flat = projective_points(triangle, [0, 0], [1, 1], 6)
    found = projective_points(moved, lo, hi, 6)
    assert np.abs(found - g.apply(flat)).max() < 1e-12


def test_projective_maps_that_are_not_shown_to_contract():
    with pytest.raises(NoContraction, match="map 1 leaves the box") as caught:
        contraction([CANTOR[0], affine([[0.5]], [1])], [0], [1])
    assert caught.value.map == 1
    with pytest.raises(NoContraction, match="map 0 has the Lipschitz bound 1 "):
        contraction([affine([[1]], [0])], [0], [1])
    with pytest.raises(NoContraction, match="map 0 cannot be bounded"):
        contraction([projective([[1, 0], [2, -1]])], [0], [1])


def test_without_two_ones_in_a_row_there_are_fibonacci_many_pieces():
    golden = ifs.shape(forbidding(from_maps(HALVES), ["1 1"]))
    counts = [
        sum(len(p.control) for p in ifs.pieces(golden.system, golden.control, depth=n)) for n in range(8)
    ]
    assert counts == [1, 2, 3, 5, 8, 13, 21, 34]
    expected = math.log((1 + math.sqrt(5)) / 2, 2)
    assert similarity_dimension(golden) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    "forbidden", [["1 1"], ["0 1 0", "1 1"], ["0 0", "2 1 0", "1 2 1"], ["0 1", "1 2", "2 0 0"]]
)
def test_restricted_pieces_are_those_whose_words_can_go_on(forbidden):
    maps = [affine([[0.25]], [shift]) for shift in (0, 0.25, 0.75)]
    shape = ifs.shape(forbidding(from_maps(maps), forbidden))
    length, more = 5, 5

    def allowed(word):
        return not any(bad in " ".join(word) for bad in forbidden)

    words = {w[:length] for w in product("012", repeat=length + more) if allowed(w)}
    expected = set()
    for word in words:
        f = maps[int(word[0])]
        for label in word[1:]:
            f = f.compose(maps[int(label)])
        expected.add(float(f.translation[0]))
    found = [p.control[:, 0, 0] for p in ifs.pieces(shape.system, shape.control, depth=length)]
    assert sorted(np.concatenate(found)) == pytest.approx(sorted(expected))


def test_dead_states_are_dropped_and_empty_languages_refused():
    plain = from_maps(HALVES)
    table = {"a": {"0": "a", "1": "b"}, "b": {"0": "c"}, "c": {}, "far": {"0": "far"}}
    found = restricted(plain, table, "a")
    assert {name: dict(cell.subdivision) for name, cell in found.cells.items()} == {"a": {"0": "a"}}
    for action, words in (
        (lambda: restricted(plain, table, "b"), "language is empty"),
        (lambda: forbidding(plain, ["0", "1"]), "language is empty"),
        (lambda: forbidding(plain, ["0 0", "1 1", "0 1 0"]), "language is empty"),
        (
            lambda: forbidding(plain, ["0 2"]),
            "unknown label '2' in the forbidden word '0 2'; the maps are 0, 1",
        ),
        (lambda: forbidding(plain, [""]), "at least one label"),
        (lambda: forbidding(plain, ["0 " * 1000]), "at most"),
        (lambda: restricted(plain, {"a": {"0": "z"}}, "a"), "to 'z', which is no state"),
        (lambda: restricted(plain, {"a": {"5": "a"}}, "a"), "unknown label '5' in state 'a'"),
        (lambda: restricted(plain, table, "q"), "'q' is no state"),
        (lambda: forbidding(found, ["0"]) and forbidding(forbidding(plain, ["1 1"]), ["0"]), "."),
    ):
        with pytest.raises(AutomatonError, match=words):
            action()


def test_the_sequence_is_splitmix64():
    state, numbers = np.uint64(1234567), []
    for _ in range(3):
        state, number = _next(state)
        state = np.uint64(state)
        numbers.append(int(number))
    assert numbers == [6457827717110365317, 3203168211198807973, 9817491932198370423]


def test_alias_tables_draw_with_the_given_chances():
    for chances in ([1.0], [0.2, 0.8], [0.01, 0.85, 0.07, 0.07], [0.0, 0.5, 0.5], list(np.full(7, 1 / 7))):
        accept, other = _alias(chances)
        found = np.zeros(len(chances))
        for k in range(len(chances)):
            found[k] += accept[k] / len(chances)
            found[other[k]] += (1 - accept[k]) / len(chances)
        assert found == pytest.approx(chances, abs=1e-14)


def _drawn(shape, count=200_000, seed=1, **more):
    return np.concatenate(list(points(shape, count, seed, **more)))


@pytest.mark.parametrize(
    "name", ["fern", "dragon", "golden", "sierpinski-tetrahedron", "takagi-curve", "closed"]
)
def test_drawn_points_have_the_exact_moments(name):
    given = None
    if name == "fern":
        found = fractint_ifs(FERN)
        shape, given = ifs.shape(found.automaton), found.probabilities
    elif name == "dragon":
        shape = ifs.shape(lsystem_automaton(DRAGON))
    elif name == "closed":
        shape = ifs.shape(lsystem_automaton("K { Angle 6\n Axiom F--F--F\n F=F+F--F+F }"))
    elif name == "golden":
        shape = ifs.shape(forbidding(from_maps(HALVES), ["1 1"]))
    else:
        shape = ifs.shape(name)
    drawn = _drawn(shape, probabilities=given)
    chances = weights(shape) if given is None else {"attractor": given}
    exact = moments(shape, 2, chances)
    mean = np.array([float(x) for x in exact.mean])
    spread = np.array([[float(x) for x in row] for row in exact.covariance])
    size = np.sqrt(np.trace(spread))
    assert np.abs(drawn.mean(axis=0) - mean).max() < 0.02 * size
    assert np.abs(np.cov(drawn.T) - spread).max() < 0.03 * size**2
    lo, hi = ifs.bounding_box(shape)
    assert (drawn >= lo - 1e-9).all()
    assert (drawn <= hi + 1e-9).all()


def test_drawn_points_depend_on_the_seed_alone():
    shape = ifs.shape("koch-curve")
    whole = _drawn(shape, 5000, seed=9)
    assert np.array_equal(whole, _drawn(shape, 5000, seed=9, chunk=77))
    assert not np.array_equal(whole, _drawn(shape, 5000, seed=10))
    assert [len(part) for part in points(shape, 10, 0, chunk=4)] == [4, 4, 2]
    assert list(points(shape, 0, 0)) == []


def test_labels_are_drawn_as_often_as_asked():
    shape = ifs.shape(from_maps(CANTOR))
    drawn = _drawn(shape, 100_000, probabilities={"0": Fraction(1, 5), "1": Fraction(4, 5)})[:, 0]
    for digits, chance in (((1,), 0.8), ((0, 1), 0.16), ((1, 1), 0.64)):
        start = sum(2 * d / 3**k for k, d in enumerate(digits, start=1))
        share = ((drawn >= start - 1e-9) & (drawn <= start + 3.0 ** -len(digits) + 1e-9)).mean()
        assert abs(share - chance) < 5 * math.sqrt(chance * (1 - chance) / 20_000)


def test_the_probabilities_taken_by_default():
    halved = [affine([[0.5]], [0]), affine([[0.25]], [0.75])]
    found = weights(ifs.shape(from_maps(halved)))["attractor"]
    golden = (math.sqrt(5) - 1) / 2
    assert [found["0"], found["1"]] == pytest.approx([golden, golden**2])
    fern = weights(ifs.shape(fractint_ifs(FERN).automaton))["attractor"]
    sizes = np.array([0, 0.7241, 0.1038, 0.1088])
    shares = np.maximum(sizes / sizes.sum(), 0.01)
    assert list(fern.values()) == pytest.approx(shares / shares.sum())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"0": 0.5, "1": 0.6}, "must sum to 1; they sum to 1.1"),
        ({"0": Fraction(1, 2), "1": Fraction(1, 3)}, "they sum to 5/6"),
        ({"0": 1.5, "1": -0.5}, r"'0' in cell 'attractor' must lie in \[0, 1\]; got 1.5"),
        ({"0": 1}, "wrong: 1"),
        ({"0": 0.5, "7": 0.5}, "wrong: 1, 7"),
        ({"edge": {"0": 1}}, "no cell 'edge'; there are attractor"),
        ({"0": 1, "attractor": {"0": 1}}, "not both"),
    ],
)
def test_wrong_probabilities(given, words):
    with pytest.raises(WrongProbabilities, match=words):
        given_weights(ifs.shape(from_maps(CANTOR)), given)


def test_wrong_counts_and_expanding_maps():
    shape = ifs.shape(from_maps(CANTOR))
    for count, seed, chunk in ((-1, 0, 1), (1, -1, 1), (1, 2**64, 1), (1, 0, 0)):
        with pytest.raises(ValueError, match="is a whole number"):
            points(shape, count, seed, chunk)
    growing = ifs.shape(from_maps([CANTOR[0], affine([[Fraction(3, 2)]], [0])]))
    with pytest.raises(ifs.NotContracting, match=r"'1' multiplies differences of points by 1\.5"):
        points(growing, 1, 0)


def test_pieces_in_chunks_are_all_pieces():
    shape = ifs.shape("sierpinski-triangle")
    found = list(pieces_in_chunks(shape, depth=6, most=50))
    assert max(len(part.control) for part in found) <= 50
    assert sum(len(part.control) for part in found) == 3**6
    with pytest.raises(ValueError, match="above 0 mm, found 0"):
        pieces_in_chunks(shape, tolerance=0)
    with pytest.raises(ValueError, match="either a size"):
        pieces_in_chunks(shape)


@pytest.mark.parametrize("name", ["koch-curve", "dragon", "sierpinski-tetrahedron"])
def test_pieces_smaller_than_a_tolerance_cover_the_attractor(name):
    shape = ifs.shape(lsystem_automaton(DRAGON)) if name == "dragon" else ifs.shape(name)
    tolerance = 4.0
    for part in pieces_in_chunks(shape, tolerance=tolerance, most=500):
        assert len(part.control) <= 500
        assert (np.linalg.norm(part.hi - part.lo, axis=1) <= tolerance).all()
    known = np.concatenate(list(points_in_chunks(shape, tolerance=tolerance)))
    distance, _ = KDTree(known).query(_drawn(shape, 20_000))
    assert np.max(distance) <= tolerance


def test_maps_are_values():
    assert affine([[0.5]], [1]) == Map(((Fraction(1, 2), Fraction(1)), (Fraction(0), Fraction(1))))
    assert projective([[2, 4], [0, 2]]) == affine([[1]], [2])
    assert len({affine([[0.5]], [1]), affine([[Fraction(1, 2)]], [1.0])}) == 1
