"""Images under homographies, hulls and polytopes: against linear programs, points, and each other."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from trees import Cube, Tree, TreeError, empty, from_array, from_points, to_points, unit_cube
from trees.geometry import (
    BeyondHorizon,
    SingularMatrix,
    from_half_spaces,
    from_hull,
    homography,
    image_of_cube,
    perspective,
    quarter_turn,
    rotation,
    scaling,
    shear,
    slab,
    transform,
    translation,
)
from trees.geometry.matrices import exact, exact_inverse, product

EPS = 1e-6


def every_cell(dimension: int, bits: int) -> np.ndarray:
    return np.stack(np.meshgrid(*[np.arange(2**bits)] * dimension, indexing="ij"), -1).reshape(-1, dimension)


def some_cells(tree: Tree, rng, most: int = 24) -> np.ndarray:
    """Cells on both sides of the edge of the set, where they are most likely wrong."""
    cells = every_cell(tree.dimension, tree.bits)
    steps = np.concatenate([np.eye(tree.dimension, dtype=int), -np.eye(tree.dimension, dtype=int)])
    black = tree.holds_cells(cells)
    edge = np.any([tree.holds_cells(cells + step) != black for step in steps], axis=0)
    cells = cells[edge]
    return cells[rng.permutation(len(cells))[:most]]


def box_of(tree: Tree, cell, wider: float) -> tuple[np.ndarray, np.ndarray]:
    low = np.array(tree.origin) + np.array(cell) * tree.cell_size
    return low - wider, low + tree.cell_size + wider


def hull_meets(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    rows = np.concatenate([points.T, -points.T])
    limits = np.concatenate([high, -low])
    equal = np.ones((1, len(points)))
    return linprog(np.zeros(len(points)), rows, limits, equal, [1.0]).status == 0


def faces_meet(faces: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    bounds = list(zip(low, high, strict=True))
    return linprog(np.zeros(len(low)), faces[:, :-1], -faces[:, -1], bounds=bounds).status == 0


def check_cells(tree: Tree, meets, rng) -> None:
    for cell in some_cells(tree, rng):
        black = tuple(cell) in tree
        if black:
            assert meets(*box_of(tree, cell, EPS))
        else:
            assert not meets(*box_of(tree, cell, -EPS))


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 4), st.integers(1, 8), st.integers(1, 4), st.integers(0, 2**32))
def test_a_hull_is_black_exactly_where_a_cell_meets_it(dimension, count, rank, seed):
    rng = np.random.default_rng(seed)
    cube = Cube((-0.5,) * dimension, 1.75)
    bits = {1: 5, 2: 4, 3: 3, 4: 2}[dimension]
    flat = rng.normal(size=(count, min(rank, dimension))) @ rng.normal(size=(min(rank, dimension), dimension))
    points = 0.3 + 0.4 * flat
    tree = from_hull(points, cube, bits)
    check_cells(tree, lambda low, high: hull_meets(points, low, high), rng)
    weights = rng.dirichlet(np.ones(count), 200)
    inner = np.concatenate([weights @ points, points])
    inside = ((inner >= -0.5) & (inner < 1.25)).all(1)
    assert tree.holds(inner[inside]).all()
    assert not from_hull(points, cube, bits, closed=False) - tree


@settings(deadline=None, max_examples=30)
@given(st.integers(1, 4), st.integers(1, 9), st.integers(0, 2**32))
def test_half_spaces_are_black_exactly_where_a_cell_meets_them(dimension, count, seed):
    rng = np.random.default_rng(seed)
    cube = Cube((1.0,) * dimension, 0.5)
    bits = {1: 5, 2: 4, 3: 3, 4: 2}[dimension]
    normals = rng.normal(size=(count, dimension))
    middle = rng.uniform(1, 1.5, dimension)
    faces = np.column_stack([normals, -normals @ middle - rng.uniform(0.01, 0.2, count)])
    tree = from_half_spaces(faces, cube, bits)
    check_cells(tree, lambda low, high: faces_meet(faces, low, high), rng)
    points = rng.uniform(1, 1.5, (300, dimension))
    inside = (points @ normals.T + faces[:, -1] <= 0).all(1)
    assert tree.holds(points[inside]).all()


def test_faces_and_corners_give_one_polytope():
    rng = np.random.default_rng(4)
    matrix = rotation(3, 0, 1, 0.4, about=[0.5] * 3) @ shear(3, 0, 2, 0.3) @ scaling([0.5, 0.4, 0.6])
    corners = transform(np.array(list(itertools.product((0.0, 1.0), repeat=3))), matrix)
    inverse = np.linalg.inv(matrix)
    faces = np.concatenate([-inverse[:3], inverse[:3] - [0, 0, 0, 1]])
    one, other = from_hull(corners, unit_cube(3), 5), from_half_spaces(faces, unit_cube(3), 5)
    assert one == other == image_of_cube(matrix, unit_cube(3), 5)
    assert one.measure > np.linalg.det(matrix)
    check_cells(one, lambda low, high: hull_meets(corners, low, high), rng)


def test_the_faces_alone_would_not_do():
    points = np.array([[0.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.9, 0.9, 0.55]])
    tree = from_hull(points, unit_cube(3), 4)
    for cell in tree:
        assert hull_meets(points, *box_of(tree, cell, EPS))


def test_solids_planes_and_empty_sets():
    cube = Cube((0.0, 0.0, 0.0), 8.0)
    whole = ~empty(cube, 3)
    assert image_of_cube(np.eye(4), cube, 3) == whole
    around = [[-9.0, -9.0, -9.0], [99.0, -9.0, -9.0], [-9.0, 99.0, -9.0], [-9.0, -9.0, 99.0]]
    assert from_hull(around, cube, 3) == whole
    assert image_of_cube(scaling([0.5] * 3), cube, 3, closed=False).count == 4**3
    assert image_of_cube(scaling([0.5] * 3), cube, 3).count == 5**3
    assert not image_of_cube(translation([8.5, 0, 0]), cube, 3)
    assert slab([0, 0, 1], 2.5, 0, cube, 3).count == 64
    assert slab([0, 0, 1], 2.0, 0, cube, 3).count == 128
    assert slab([0, 0, -2], -5, 1.5, cube, 3).count == 3 * 64
    assert image_of_cube(scaling([1, 1, 2.0**-3], about=[0, 0, 4]), cube, 3, closed=False).count == 2 * 64
    assert from_half_spaces([[1, 0, 0, 1]], cube, 2) == empty(cube, 2)
    assert from_half_spaces(np.zeros((0, 4)), cube, 2) == ~empty(cube, 2)
    assert from_hull([[1.5] * 3], cube, 3) == from_points([[1, 1, 1]], 3, cube)
    point = from_hull([[2.0] * 3], cube, 3)
    assert set(point) == set(itertools.product((1, 2), repeat=3))


def test_a_hull_in_six_dimensions():
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 1, (9, 6))
    tree = from_hull(points, unit_cube(6), 2)
    check_cells(tree, lambda low, high: hull_meets(points, low, high), rng)


def union_of_images(tree: Tree, matrix: np.ndarray, cube: Cube, bits: int) -> Tree:
    """Cell by cell: the hulls of the images of the corners."""
    found = empty(cube, bits)
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=tree.dimension)))
    for cell in to_points(tree).astype(float):
        points = np.array(tree.origin) + (cell + corners) * tree.cell_size
        found |= from_hull(transform(points, matrix), cube, bits)
    return found


def random_tree(rng, dimension: int, bits: int, cube: Cube, most: int = 12) -> Tree:
    count = int(rng.integers(1, most))
    return from_points(rng.integers(0, 2**bits, (count, dimension)), bits, cube)


@settings(deadline=None, max_examples=50)
@given(st.integers(1, 4), st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32))
def test_affine_images_are_the_union_of_the_images_of_cells(dimension, bits, other, seed):
    rng = np.random.default_rng(seed)
    bits, other = min(bits, 8 // dimension), min(other, 10 // dimension)
    tree = random_tree(rng, dimension, bits, Cube((-1.0,) * dimension, 1.5))
    matrix = np.eye(dimension + 1)
    matrix[:-1] = rng.normal(size=(dimension, dimension + 1))
    cube = Cube((-2.0,) * dimension, 3.25)
    image = homography(tree, -3.0 * matrix, cube, other)
    assert image == union_of_images(tree, matrix, cube, other)
    assert not homography(tree, matrix, cube, other, closed=False) - image


@settings(deadline=None, max_examples=50)
@given(st.integers(1, 3), st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32))
def test_perspective_images_cover_and_stay_near(dimension, bits, other, seed):
    rng = np.random.default_rng(seed)
    bits, other = min(bits, 8 // dimension), min(other, 10 // dimension)
    tree = random_tree(rng, dimension, bits, unit_cube(dimension))
    matrix = np.eye(dimension + 1)
    matrix[:-1] = rng.normal(size=(dimension, dimension + 1))
    matrix[-1, :-1] = rng.normal(size=dimension)
    matrix[-1, -1] = -np.minimum(matrix[-1, :-1], 0).sum() + rng.uniform(0.02, 2)
    cube = Cube((-1.5,) * dimension, 4.0)
    image = homography(tree, rng.choice([-2.0, 0.5]) * matrix, cube, other)
    cells = union_of_images(tree, matrix, cube, other)
    assert not cells - image
    if dimension < 3:
        assert image == cells
    boxes = empty(cube, other)
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))
    for cell in to_points(tree).astype(float):
        points = transform((cell + corners) * tree.cell_size, matrix)
        ends = np.stack([points.min(0), points.max(0)])
        boxes |= from_hull(
            [[ends[b, i] for i, b in enumerate(c)] for c in itertools.product((0, 1), repeat=dimension)],
            cube,
            other,
        )
    assert not image - boxes


@pytest.mark.parametrize("projective", [False, True])
@pytest.mark.parametrize("dimension", [2, 3, 4, 5])
def test_every_point_of_a_black_cell_lands_in_a_black_cell(dimension, projective):
    rng = np.random.default_rng(dimension)
    bits = {2: 5, 3: 4, 4: 2, 5: 2}[dimension]
    tree = from_array(rng.random((2**bits,) * dimension) < 0.15)
    middle = [0.5] * dimension
    matrix = rotation(dimension, 0, dimension - 1, 0.7, middle) @ rotation(dimension, 0, 1, 0.4, middle)
    if projective:
        matrix = perspective([0.4, *[-0.2] * (dimension - 1)], middle) @ matrix
    image = homography(tree, matrix)
    cells = to_points(tree).astype(float)
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))
    places = np.concatenate([corners, rng.uniform(0, 1, (20, dimension)), [middle]])
    points = ((cells[:, None] + places) * tree.cell_size).reshape(-1, dimension)
    landed = transform(points, matrix)
    inside = ((landed >= 0) & (landed < 1)).all(1)
    assert inside.sum() > 100
    assert image.holds(landed[inside]).all()
    assert image.count < 2 ** (bits * dimension)


def test_lattice_maps_are_exact_when_contact_does_not_count():
    rng = np.random.default_rng(1)
    for dimension, bits in ((1, 5), (2, 4), (3, 3), (4, 2)):
        tree = from_array(rng.random((2**bits,) * dimension) < 0.3, Cube((0.1,) * dimension, 0.7))
        assert homography(tree, np.eye(dimension + 1), closed=False) == tree
        whole = ~empty(tree.cube, bits)
        assert homography(whole, np.eye(dimension + 1)) == whole
        if dimension > 1:
            about = [0.1 + 0.35] * dimension
            turn = rotation(dimension, 0, 1, np.pi / 2, about)
            assert homography(tree, turn, closed=False) == quarter_turn(tree, 0, 1)
        fine = homography(tree, np.eye(dimension + 1), bits=bits + 1, closed=False)
        assert fine == tree.at(bits + 1)
        assert homography(tree, np.eye(dimension + 1), bits=bits - 1, closed=False) == tree.at(bits - 1)


def test_touching_cells_count_as_a_closed_set_asks():
    tree = from_points([[1, 1]], 2)
    assert set(homography(tree, np.eye(3))) == set(itertools.product(range(3), repeat=2))


def test_large_solids_cost_their_surface():
    block = from_points([[0, 0, 0]], 1).at(9)
    image = homography(block, rotation(3, 0, 1, 0.3, about=[0.25] * 3))
    side = 0.5 + 2 * 2.0**-9 * np.sqrt(3)
    assert 0.85 * 0.125 < image.measure < side**3
    deep = from_points([[2**20, 2**20, 2**20]], 21)
    found = homography(deep, rotation(3, 1, 2, 0.3, about=[0.5] * 3))
    assert found.holds(np.array([[0.5, 0.5, 0.5]])).all()
    assert 0 < found.count < 30


def test_the_horizon():
    cube = Cube((-1.0, -1.0), 2.0)
    matrix = perspective([1.0, 0.0])
    right = from_array(np.array([[False, False], [True, True]]), cube).at(3)
    image = homography(right, matrix)
    assert image.holds(np.array([[0.25, 0.3], [0.49, 0.0]])).all()
    assert not image.holds(np.array([[0.8, 0.0], [-0.3, 0.0]])).any()
    everything = ~empty(cube, 3)
    with pytest.raises(BeyondHorizon, match=r"cell \(0, 0\)") as caught:
        homography(everything, matrix)
    assert caught.value.weight == pytest.approx(0)
    with pytest.raises(BeyondHorizon, match="point 0"):
        image_of_cube(matrix, cube, 3)
    behind = from_points([[0, 0]], 3, cube)
    with pytest.raises(BeyondHorizon):
        homography(behind, matrix)
    assert homography(behind, perspective([4.0, 0.0]))
    cut = everything & from_half_spaces([[-1.0, 0.0, -0.6]], cube, 3, closed=False)
    assert homography(cut, matrix, Cube((-8.0, -8.0), 16.0), 4).count > 0


def test_wrong_maps_are_named():
    tree = from_points([[1, 1]], 2)
    with pytest.raises(SingularMatrix, match="rank 2") as caught:
        homography(tree, scaling([1.0, 0.0]))
    assert (caught.value.rank, caught.value.needed) == (2, 3)
    with pytest.raises(TreeError, match=r"shape \(4, 4\): \(3, 3\)"):
        homography(tree, np.eye(4))
    with pytest.raises(TreeError, match="row 1, column 2"):
        homography(tree, translation([0.0, np.nan]))
    with pytest.raises(TreeError, match="cube of dimension 3"):
        homography(tree, np.eye(3), unit_cube(3))
    with pytest.raises(TreeError, match="axes 1 and 1"):
        rotation(2, 1, 1, 0.2)
    with pytest.raises(TreeError, match="axis 2"):
        shear(2, 2, 1, 0.2)
    with pytest.raises(TreeError, match="point 1: coordinate inf on axis 0"):
        from_hull([[0.0, 0.0], [np.inf, 1.0]], unit_cube(2), 2)
    with pytest.raises(TreeError, match="at least one"):
        from_hull(np.zeros((0, 2)), unit_cube(2), 2)
    with pytest.raises(TreeError, match="face 1: the normal is 0"):
        from_half_spaces([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], unit_cube(2), 2)
    with pytest.raises(TreeError, match="face 0: coefficient nan"):
        from_half_spaces([[1.0, np.nan, 0.0]], unit_cube(2), 2)
    with pytest.raises(TreeError, match="thickness -1"):
        slab([1.0, 0.0], 0.0, -1.0, unit_cube(2), 2)


def test_matrices_and_exact_inverses():
    rng = np.random.default_rng(0)
    matrix = rng.normal(size=(5, 5))
    rows = exact(matrix)
    identity = product(rows, exact_inverse(rows))
    assert identity == [[Fraction(i == j) for j in range(5)] for i in range(5)]
    point = rng.normal(size=(1, 3))
    assert transform(transform(point, perspective([0.1, 0.2, 0.3])), perspective([-0.1, -0.2, -0.3])) == (
        pytest.approx(point)
    )
    turn = rotation(3, 0, 2, 0.3, about=[1.0, 2.0, 3.0])
    assert turn @ [1, 2, 3, 1] == pytest.approx([1, 2, 3, 1])
    assert turn @ rotation(3, 0, 2, -0.3, about=[1.0, 2.0, 3.0]) == pytest.approx(np.eye(4))
    assert shear(2, 0, 1, 2.0, about=[5.0, 1.0]) @ [5, 2, 1] == pytest.approx([7, 2, 1])


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 3), st.integers(0, 4), st.integers(0, 4), st.floats(-9, 1), st.integers(0, 2**32))
def test_the_cover_holds_in_exact_fractions_close_to_the_horizon(dimension, bits, other, nearness, seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, dimension, bits, unit_cube(dimension), 4)
    matrix = np.eye(dimension + 1)
    matrix[:-1] = rng.normal(size=(dimension, dimension + 1))
    matrix[-1, :-1] = rng.normal(size=dimension)
    matrix[-1, -1] = -np.minimum(matrix[-1, :-1], 0).sum() + 10.0**nearness
    first = (to_points(tree)[0] + rng.random(dimension)) * tree.cell_size
    middle = transform(first[None], matrix)[0]
    size = 10.0 ** rng.uniform(-3, 2)
    cube = Cube(tuple((middle - size * rng.random(dimension)).tolist()), size)
    image = homography(tree, matrix, cube, other)
    rows = exact(matrix)
    for cell in tree:
        for steps in rng.integers(0, 9, (10, dimension)).tolist():
            point = [Fraction(8 * x + step, 8 * 2**bits) for x, step in zip(cell, steps, strict=True)]
            column = [sum(a * b for a, b in zip(row, [*point, Fraction(1)], strict=True)) for row in rows]
            place = [
                (y / column[-1] - Fraction(start)) / Fraction(size) * 2**other
                for y, start in zip(column[:-1], cube.origin, strict=True)
            ]
            if all(0 <= x < 2**other for x in place):
                assert tuple(int(x) for x in place) in image
