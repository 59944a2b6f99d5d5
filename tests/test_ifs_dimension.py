"""Dimensions against closed forms: Moran's and Mauldin and Williams' equations, and counts of boxes."""

import numpy as np
import pytest
from scipy.optimize import brentq

import ifs
from automata import parse_text
from ifs.dimensions.affinity import affinity_bound
from ifs.dimensions.boxcounting import box_counting
from ifs.dimensions.dimension import dimension, natural_probabilities, similarity, similarity_dimension
from subdivision.schemes import b_spline, cesaro

GOLDEN = """
format = "bcifs/1"
name = "Words without two ones"
shape = "any"
[cells.any]
points = 2
subdivision = { 0 = "any", 1 = "zero" }
matrices = { 0 = [[1, "2/3"], [0, "1/3"]], 1 = [["1/3", 0], ["2/3", 1]] }
[cells.zero]
points = 2
subdivision = { 0 = "any" }
matrices = { 0 = [[1, "2/3"], [0, "1/3"]] }
[control]
points = [[0, 0], [27, 0]]
"""


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("koch-curve", np.log(4) / np.log(3)),
        ("menger-sponge", np.log(20) / np.log(3)),
        ("sierpinski-triangle", np.log(3) / np.log(2)),
        ("sierpinski-tetrahedron", 2.0),
    ],
)
def test_similarity_dimensions(name, expected):
    found = dimension(ifs.shape(name))
    assert found.kind == "similarity"
    assert found.value == pytest.approx(expected, abs=1e-12)


def test_the_golden_ratio_of_a_graph_directed_set():
    # The matrix of labels [[1, 1], [1, 0]] has the golden ratio as its radius; every letter takes a third.
    shape = ifs.shape(parse_text(GOLDEN))
    golden = (1 + np.sqrt(5)) / 2
    assert similarity_dimension(shape) == pytest.approx(np.log(golden) / np.log(3), abs=1e-12)
    shares = natural_probabilities(shape.system, similarity(shape))
    assert shares["any"]["0"] == pytest.approx(1 / golden)
    assert shares["zero"]["0"] == pytest.approx(1)
    for row in shares.values():
        assert sum(row.values()) == pytest.approx(1)


def test_unequal_ratios_solve_morans_equation():
    maps = "".join(
        f"[[maps]]\nlinear = [['{ratio}']]\ntranslation = ['{shift}']\n"
        for ratio, shift in (("1/2", 0), ("1/3", "2/3"))
    )
    shape = ifs.shape(parse_text(f"format = 'bcifs/1'\nname = 'x'\n{maps}[control]\npoints = [[0], [1]]"))
    root = brentq(lambda s: 2.0**-s + 3.0**-s - 1, 0, 1, xtol=1e-15)
    assert similarity_dimension(shape) == pytest.approx(root, abs=1e-12)


def test_an_affine_view_of_similarities_is_bounded_by_their_dimension():
    slanted = ifs.shape("sierpinski-triangle", control=np.array([[0, 0], [80, 3], [11, 25]]))
    # All pieces are translates times 1/2, so these stay similarities; the Koch curve's rotations do not.
    assert similarity_dimension(slanted) == pytest.approx(np.log(3) / np.log(2))
    squeezed = ifs.shape("koch-curve", control=np.array([[0, 0], [45, 10], [90, 0]]))
    assert similarity_dimension(squeezed) is None
    bound = affinity_bound(squeezed)
    assert np.log(4) / np.log(3) <= bound + 1e-9  # the dimension is kept by the affine map
    assert bound < 1.45


def test_smooth_curves_are_bounded_near_one():
    assert 1 <= affinity_bound(ifs.shape(b_spline(2))) < 1.1
    assert similarity_dimension(ifs.shape(b_spline(2))) is None


@pytest.mark.parametrize("source", ["koch-curve", "sierpinski-triangle", cesaro(80)])
def test_boxes_count_the_similarity_dimension(source):
    shape = ifs.shape(source)
    expected = similarity_dimension(shape)
    found = box_counting(shape, most=100_000)
    assert found.dimension == pytest.approx(expected, abs=0.06)
    assert found.low - 0.02 <= expected <= found.high + 0.02
    assert (np.diff(found.counts) > 0).all()


def test_wrong_requests_for_boxes():
    with pytest.raises(ValueError, match="number of scales is a whole number, 4 or more"):
        box_counting(ifs.shape("koch-curve"), scales=3)
    with pytest.raises(ValueError, match="coincide"):
        box_counting(ifs.shape("koch-curve", control=np.zeros((3, 2))))
