"""Principal frames and normalised trees of shapes under similarities."""

import numpy as np
import pytest

from trees import Cube, TreeError, empty, from_array, from_points, unit_cube
from trees.measures import jaccard_distance, moments, normalised, principal_frame

CUBE = Cube((-2.0,) * 3, 4.0)


def rotation(seed: int, dimension: int = 3) -> np.ndarray:
    found = np.linalg.qr(np.random.default_rng(seed).normal(size=(dimension, dimension)))[0]
    return found * np.sign(np.linalg.det(found))


def placed(inside, turn: np.ndarray, scale: float, move, bits: int = 6):
    """The cells whose centres, moved back, are in the shape."""
    side = 2**bits
    axes = np.indices((side,) * 3).reshape(3, -1).T
    points = (axes + 0.5) * (4 / side) - 2
    back = (points - np.array(move)) @ turn / scale
    return from_array(inside(back).reshape((side,) * 3), CUBE)


def ell(x):
    """An L of unequal legs and thickness: no symmetry but the mirror of its plane."""
    foot = (abs(x[:, 0]) < 0.9) & (abs(x[:, 1] + 0.4) < 0.25)
    leg = (abs(x[:, 0] + 0.6) < 0.3) & (abs(x[:, 1]) < 0.65)
    return (foot | leg) & (abs(x[:, 2]) < 0.2)


def screw(x):
    """Boxes without a mirror plane."""
    first = (abs(x[:, 0]) < 1) & (abs(x[:, 1]) < 0.3) & (abs(x[:, 2]) < 0.2)
    second = (abs(x[:, 0] - 0.7) < 0.3) & (abs(x[:, 1] - 0.4) < 0.5) & (abs(x[:, 2]) < 0.2)
    third = (abs(x[:, 0] + 0.5) < 0.2) & (abs(x[:, 1]) < 0.3) & (abs(x[:, 2] - 0.4) < 0.4)
    return first | second | third


def tetrahedron(x):
    normals = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    return (x @ normals.T < 1).all(axis=1)


def test_axes_of_an_ellipsoid_are_found_and_its_signs_are_left_open():
    turn = rotation(3)
    tree = placed(lambda x: ((x / [1.4, 0.9, 0.5]) ** 2).sum(1) < 1, turn, 1.0, [0.1, -0.2, 0.3])
    frame = principal_frame(tree)
    assert frame.centroid == pytest.approx([0.1, -0.2, 0.3], abs=0.01)
    # The variance of an ellipsoid along an axis is that of its half-axis squared, over 5.
    assert frame.variances == pytest.approx(np.array([1.4, 0.9, 0.5]) ** 2 / 5, rel=0.02)
    assert abs((frame.axes @ turn).round(3)) == pytest.approx(np.eye(3), abs=0.03)
    assert not frame.signed.any()
    assert frame.groups.tolist() == [0, 1, 2]
    assert not frame.unique
    assert len(frame.alternatives()) == 8
    assert frame.alternatives()[1].axes != pytest.approx(frame.axes)


def test_axes_are_orthonormal_and_skewness_is_not_negative():
    rng = np.random.default_rng(1)
    for dimension, side in ((1, 64), (2, 16), (3, 8), (4, 4), (5, 4)):
        array = rng.random((side,) * dimension) < 0.3
        frame = principal_frame(from_array(array), tolerance=0.0)
        assert frame.axes @ frame.axes.T == pytest.approx(np.eye(dimension))
        assert (frame.skewness >= 0).all()
        assert (np.diff(frame.variances) <= 0).all()
        # A cell adds the variance of a unit cube to that of the centres.
        centred = (np.argwhere(array) - np.argwhere(array).mean(0)) / side
        assert frame.variances == pytest.approx((centred @ frame.axes.T).var(0) + 1 / (12 * side**2))
        assert frame.skewness == pytest.approx(((centred @ frame.axes.T) ** 3).mean(0), abs=1e-12)


@pytest.mark.parametrize("unit", ["inertia", "volume"])
def test_the_normalised_tree_is_the_same_under_similarities(unit):
    sizes, found = (0.8, 1.0, 1.3), []
    for seed, size in enumerate(sizes):
        tree = placed(screw, rotation(seed), size, [0.2 * seed, 0.0, -0.1])
        frame = principal_frame(tree)
        assert frame.unique
        found.append(normalised(tree, 6, unit))
    for other in found[1:]:
        assert jaccard_distance(found[0], other) < 0.25
    # The turned box reaches across the axes: without the turn, nothing of this holds.
    bent = normalised(placed(ell, rotation(0), 1.0, [0, 0, 0]), 6, unit, clip=True)
    assert jaccard_distance(found[0], bent) > 0.4
    if unit == "volume":
        assert [tree.measure for tree in found] == pytest.approx([1.0] * 3, rel=0.05)


def test_mirror_images_are_one_unless_the_frame_is_proper():
    tree = placed(screw, rotation(4), 1.0, [0, 0, 0])
    image = placed(lambda x: screw(x * [1, 1, -1]), rotation(4), 1.0, [0, 0, 0])
    one, other = normalised(tree, 6), normalised(image, 6)
    assert jaccard_distance(one, other) < 0.25
    frames = [principal_frame(some, proper=True) for some in (tree, image)]
    assert not frames[0].mirrored
    assert not frames[1].mirrored
    one, other = (normalised(some, 6, frame=f) for some, f in zip((tree, image), frames, strict=True))
    assert jaccard_distance(one, other) > 0.3


@pytest.mark.parametrize("shape", [lambda x: abs(x).max(1) < 0.7, tetrahedron])
def test_shapes_with_equal_variances_are_turned_by_higher_moments(shape):
    trees = [placed(shape, rotation(seed), 1.0, [0.1, 0, 0]) for seed in range(3)]
    frames = [principal_frame(tree) for tree in trees]
    assert all(frame.groups.tolist() == [0, 0, 0] for frame in frames)
    closest = [
        min(
            jaccard_distance(normalised(trees[0], 5), normalised(tree, 5, frame=f))
            for f in frame.alternatives()
        )
        for tree, frame in zip(trees[1:], frames[1:], strict=True)
    ]
    assert max(closest) < 0.2


def test_what_cannot_be_normalised_is_refused():
    with pytest.raises(TreeError, match="empty set"):
        normalised(empty(unit_cube(2), 3), 3)
    comet = from_points([[x, 0] for x in (0, 1, 2, 3, 255)] + [[x, 1] for x in range(64)], bits=8)
    with pytest.raises(TreeError, match=r"reaches 6\.\d+ units"):
        normalised(comet, 4)
    assert normalised(comet, 8, clip=True)
    with pytest.raises(TreeError, match="unit 'mass'"):
        normalised(comet, 4, unit="mass")
    with pytest.raises(TreeError, match="reach of 0"):
        normalised(comet, 4, reach=0)
    with pytest.raises(TreeError, match="order 3"):
        principal_frame(moments(comet, 3))
    with pytest.raises(TreeError, match="tolerance of 2"):
        principal_frame(comet, tolerance=2)
