"""The figures of a level as solids: volumes, loops, inside and outside, against closed forms and planes."""

from itertools import combinations

import numpy as np
import pytest
from scipy import ndimage

import ifs
from automata import parse_text
from export import make_part, voxelise
from export.prepare import prepare
from export.voxels.estimate import estimate, faces_of
from export.voxels.frame import frame_around, subject
from export.voxels.level import EIGHTHS, HALVES, QUARTERS, level_of
from trees import to_array

FOUR = """
format = "bcifs/1"
name = "four"
shape = "whole"

[cells.whole]
points = 4
subdivision = { 0 = "whole", 1 = "whole", 2 = "whole", 3 = "whole" }
figure = FIGURE

[cells.whole.matrices]
0 = [[1, "1/2", "1/2", "1/2"], [0, "1/2", 0, 0], [0, 0, "1/2", 0], [0, 0, 0, "1/2"]]
1 = [["1/2", 0, 0, 0], ["1/2", 1, "1/2", "1/2"], [0, 0, "1/2", 0], [0, 0, 0, "1/2"]]
2 = [["1/2", 0, 0, 0], [0, "1/2", 0, 0], ["1/2", "1/2", 1, "1/2"], [0, 0, 0, "1/2"]]
3 = [["1/2", 0, 0, 0], [0, "1/2", 0, 0], [0, 0, "1/2", 0], ["1/2", "1/2", "1/2", 1]]

[control]
points = [[0, 0, 0], [16, 0, 0], [0, 16, 0], [0, 0, 16]]
"""
TRIANGLE = """
format = "bcifs/1"
name = "triangle"
shape = "whole"

[cells.whole]
points = 3
subdivision = { 0 = "whole", 1 = "whole", 2 = "whole" }
figure = FIGURE

[cells.whole.matrices]
0 = [[1, "1/2", "1/2"], [0, "1/2", 0], [0, 0, "1/2"]]
1 = [["1/2", 0, 0], ["1/2", 1, "1/2"], [0, 0, "1/2"]]
2 = [["1/2", 0, 0], [0, "1/2", 0], ["1/2", "1/2", 1]]

[control]
points = [[0, 0], [64, 0], [0, 64]]
"""
CLOSED = "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]"
CORNERS = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
FAR = "[[1, 0, 0, 0], [-1, 2, 0, 0], [-1, 0, 2, 0], [-1, 0, 0, 2]]"
OCTAHEDRON = """[["1/2", "1/2", 0, 0], ["1/2", 0, "1/2", 0], ["1/2", 0, 0, "1/2"],
    [0, "1/2", "1/2", 0], [0, "1/2", 0, "1/2"], [0, 0, "1/2", "1/2"]]"""
EIGHT_FACES = "[[0, 1, 2], [0, 2, 4], [0, 4, 3], [0, 3, 1], [5, 2, 1], [5, 4, 2], [5, 3, 4], [5, 1, 3]]"


def four(figure: str) -> ifs.Shape:
    return ifs.shape(parse_text(FOUR.replace("FIGURE", figure.replace("\n", " "))))


def triangle(figure: str) -> ifs.Shape:
    return ifs.shape(parse_text(TRIANGLE.replace("FIGURE", figure)))


def tetrahedra(level: int) -> np.ndarray:
    """The corners of the tetrahedra of a level, `(pieces, 4, 3)`."""
    shape = ifs.shape("sierpinski-tetrahedron")
    return np.concatenate([batch.control for batch in ifs.pieces(shape.system, shape.control, depth=level)])


def black_of(cover) -> np.ndarray:
    return to_array(cover.tree)[tuple(slice(n) for n in cover.size)]


def bodies(black: np.ndarray, joined: np.ndarray) -> int:
    """How many connected parts an array has."""
    return int(np.max(np.asarray(ndimage.label(black, joined)[0])))  # type: ignore[index]


def planes(tetrahedron: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals to the outside and offsets of the four half-spaces."""
    normals, offsets = [], []
    for face in combinations(range(4), 3):
        a, b, c = tetrahedron[list(face)]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        inside = tetrahedron.mean(axis=0)
        normal *= np.sign(normal @ (a - inside))
        normals.append(normal)
        offsets.append(normal @ a)
    return np.array(normals), np.array(offsets)


def meeting(tetrahedron: np.ndarray, low: np.ndarray, high: np.ndarray, slack: float) -> np.ndarray:
    """Which boxes a tetrahedron meets: no axis of faces or of two edges tells them apart (to the slack)."""
    near = ((low <= tetrahedron.max(axis=0) + slack) & (high >= tetrahedron.min(axis=0) - slack)).all(axis=1)
    if not near.all():
        near[near] = meeting(tetrahedron, low[near], high[near], slack)
        return near
    edges = [b - a for a, b in combinations(tetrahedron, 2)]
    axes = [*np.eye(3), *planes(tetrahedron)[0]]
    axes += [np.cross(edge, unit) for edge in edges for unit in np.eye(3)]
    meets = np.ones(len(low), dtype=bool)
    for axis in axes:
        length = np.linalg.norm(axis)
        if length < 1e-9:
            continue
        axis = axis / length
        along = tetrahedron @ axis
        least = np.where(axis > 0, low, high) @ axis
        most = np.where(axis > 0, high, low) @ axis
        meets &= (least <= along.max() + slack) & (most >= along.min() - slack)
    return meets


@pytest.mark.parametrize("parts", [HALVES, QUARTERS, EIGHTHS])
def test_parts_of_a_simplex_fill_it_once(parts):
    size = len(parts[0])
    matrices = []
    for part in parts:
        columns = np.zeros((size, size))
        for column, means in enumerate(part):
            columns[list(means), column] = 1 / len(means)
        matrices.append(columns)
    shares = [abs(np.linalg.det(each)) for each in matrices]
    np.testing.assert_allclose(shares, 0.5 ** (size - 1))
    assert sum(shares) == pytest.approx(1)
    points = np.random.default_rng(1).dirichlet(np.ones(size), 2000).T
    inside = np.array([(np.linalg.solve(each, points) > 1e-12).all(axis=0) for each in matrices])
    assert (inside.sum(axis=0) == 1).all()


@pytest.mark.parametrize("level", [1, 3])
def test_the_volume_is_that_of_tetrahedra(level):
    """Too much by less than a layer of voxels around the faces, and ever less."""
    shape = ifs.shape("sierpinski-tetrahedron")
    exact = 60**3 / (6 * np.sqrt(2)) / 2**level
    area = np.sqrt(3) * 60**2  # of all levels alike
    edges = 6 * 60 * 2**level
    over = []
    for resolution in (60, 120, 240):
        cover = voxelise(shape, resolution, depth=level)
        reach = np.sqrt(3) * cover.pitch
        over.append(cover.tree.measure - exact)
        assert 0 < over[-1] < area * reach + edges * np.pi * reach**2 + 4**level * 4 * np.pi * reach**3 / 3
    assert over[1] < 0.75 * over[0]
    assert over[2] < 0.6 * over[1]
    assert over[2] == pytest.approx(area * 60 / 240, rel=0.5)


@pytest.mark.parametrize(("level", "resolution"), [(0, 24), (1, 40)])
@pytest.mark.parametrize("part", [1.0, 0.125])
def test_black_voxels_are_those_that_tetrahedra_meet(level, resolution, part):
    cover = voxelise(ifs.shape("sierpinski-tetrahedron"), resolution, depth=level, part=part)
    black = black_of(cover)
    places = np.argwhere(np.ones_like(black))
    low = np.array(cover.tree.cube.origin) + cover.pitch * places
    met, surely, near = (np.zeros(len(places), dtype=bool) for _ in range(3))
    for each in tetrahedra(level):
        met |= meeting(each, low, low + cover.pitch, 1e-5 * cover.pitch)
        surely |= meeting(each, low, low + cover.pitch, -1e-5 * cover.pitch)
        near |= meeting(each, low, low + cover.pitch, part * np.sqrt(3) * cover.pitch)
    filled = black.ravel()
    assert filled[surely].all()
    assert not filled[~near].any()
    more = np.count_nonzero(filled & ~met) / np.count_nonzero(met)
    assert more < {1.0: 0.12, 0.125: 0.01}[part]
    random = np.random.default_rng(level)
    weights = random.dirichlet(np.ones(4), 4000)
    points = np.concatenate([weights @ each for each in tetrahedra(level)])
    cells = np.floor((points - cover.tree.cube.origin) / cover.pitch).astype(int)
    assert black[tuple(cells.T)].all()


@pytest.mark.parametrize(("level", "resolution"), [(1, 12), (2, 60), (3, 60), (4, 120)])
def test_tetrahedra_that_touch_at_corners_keep_all_loops(level, resolution):
    """4^n solids that touch at 2 (4^n - 1) points: 2 (4^n - 1) - 4^n + 1 loops."""
    part = make_part(ifs.shape("sierpinski-tetrahedron"), size=60, depth=level, resolution=resolution)
    assert part.report.ok
    assert part.report.genus == (4**level - 1,)


def test_the_frame_is_that_of_the_shape():
    shape = ifs.shape("sierpinski-tetrahedron")
    found = subject(shape)
    for depth in range(5):
        level = level_of(found, shape, depth)
        assert level is not None
        assert level.corners == found.corners
        for state in level.system.states.values():
            for operator in state.operators:
                np.testing.assert_allclose(operator.sum(axis=0), 1, atol=1e-14)
        assert len(level.system.states) == depth + 2


@pytest.mark.parametrize(
    "figure", ['"polygon"', "{ faces = [[0, 2, 1]], points = [[1,0,0],[0,1,0],[0,0,1]] }"]
)
@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_triangles_in_the_plane(figure, level):
    """On a lattice: of each right triangle of s voxels the s (s + 1) / 2 squares that it meets."""
    shape = triangle(figure)
    cover = voxelise(shape, 64, depth=level)
    black = black_of(cover)
    assert black.shape == (64, 64, 1)
    expected = np.zeros((64, 64), dtype=bool)
    side = 64 >> level
    for x in range(0, 64, side):
        for y in range(0, 64, side):
            if not (x // side) & (y // side):
                i, j = np.indices((side, side))
                expected[x : x + side, y : y + side] = i + j < side
    assert np.array_equal(black[:, :, 0], expected)


def test_a_fan_of_triangles_fills_a_polygon():
    text = """
format = "bcifs/1"
name = "square"
shape = "square"

[cells.square]
points = 4
subdivision = { 0 = "square", 1 = "square" }
figure = "polygon"

[cells.square.matrices]
0 = [["1", "3/4", "1/2", "3/4"], [0, "1/4", "1/4", 0], [0, 0, "1/4", 0], [0, 0, 0, "1/4"]]
1 = [["1/4", 0, 0, 0], [0, "1/4", 0, 0], ["1/2", "3/4", "1", "3/4"], ["1/4", 0, 0, "1/4"]]

[control]
points = [[0, 0], [32, 0], [32, 32], [0, 32]]
"""
    shape = ifs.shape(parse_text(text))
    whole = voxelise(shape, 32, depth=0)
    assert black_of(whole).all()
    corners = np.concatenate([b.control for b in ifs.pieces(shape.system, shape.control, depth=1)])
    area = 0.0
    for x, y in (corner.T for corner in corners):
        area += abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    cover = voxelise(shape, 512, depth=1)
    assert cover.tree.count * cover.pitch**2 == pytest.approx(area, rel=0.03)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_segments(level):
    """The first and the last corner: the left sides of the triangles, in columns with gaps."""
    cover = voxelise(triangle('"segment"'), 128, depth=level)
    corners = np.concatenate(
        [
            b.control
            for b in ifs.pieces(triangle('"segment"').system, triangle('"segment"').control, depth=level)
        ]
    )
    ends = corners[:, [0, 2]]
    share = np.linspace(0, 1, 1001)[:, None, None]
    points = (ends[:, 0] * (1 - share) + ends[:, 1] * share).reshape(-1, 2)
    lows, highs = points.min(axis=0), points.max(axis=0)
    assert cover.pitch * 128 == pytest.approx((highs - lows).max())
    black = np.argwhere(black_of(cover)[:, :, 0])
    centres = np.array(cover.tree.cube.origin)[:2] + cover.pitch * (black + 0.5)
    distance = np.abs(centres[:, None] - points[None]).max(axis=2)
    assert (distance.min(axis=1) <= 0.5 * cover.pitch * (1 + 1e-6) + 64 / 1000).all()
    assert (distance.min(axis=0) <= 0.5 * cover.pitch * (1 + 1e-6)).all()
    side = 1 << level
    rows = [[j for j in range(side) if not i & j] for i in range(side)]
    runs = sum(j - 1 not in row for row in rows for j in row)
    assert bodies(black_of(cover)[:, :, 0], np.ones((3, 3))) == runs


def test_a_figure_beyond_the_attractor_has_its_own_box():
    shape = four(f"{{ points = {FAR}, faces = {CLOSED} }}")
    frame = frame_around(level_of(subject(shape), shape, 1) or shape, 48)
    assert frame.pitch * 48 == pytest.approx(24)  # the pieces of side 16 begin at 0 and at 8
    cover = voxelise(shape, 48, depth=1)
    assert cover.size == frame.size
    assert cover.tree.measure > 4 * 16**3 / 6 - 3 * 8**3 / 6
    made = prepare(shape, size=12.0, resolution=48, depth=1)
    assert made.cover.pitch == pytest.approx(0.25)
    limit = voxelise(shape, 48)
    assert limit.pitch == pytest.approx(16 / 48)


def test_a_closed_figure_is_filled_and_an_open_one_is_not():
    solid = black_of(voxelise(four(f"{{ points = {OCTAHEDRON}, faces = {EIGHT_FACES} }}"), 64, depth=0))
    some = EIGHT_FACES.replace(", [5, 1, 3]", "")
    skin = black_of(voxelise(four(f"{{ points = {OCTAHEDRON}, faces = {some} }}"), 64, depth=0))
    assert solid[skin].all()
    assert solid.sum() * 0.125**3 == pytest.approx(16**3 / 6 / 2, rel=0.1)
    assert skin.sum() < 0.5 * solid.sum()
    assert bodies(~np.pad(solid, 1), ndimage.generate_binary_structure(3, 1)) == 1


def test_two_closed_figures_are_filled_apart():
    small = """[[1, 0, 0, 0], ["3/4", "1/4", 0, 0], ["3/4", 0, "1/4", 0], ["3/4", 0, 0, "1/4"],
        ["1/4", "3/4", 0, 0], [0, 1, 0, 0], [0, "3/4", "1/4", 0], [0, "3/4", 0, "1/4"]]"""
    faces = "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 6, 5], [4, 5, 7], [5, 6, 7], [6, 4, 7]]"
    cover = voxelise(four(f"{{ points = {small}, faces = {faces} }}"), 128, depth=0)
    assert bodies(black_of(cover), np.ones((3, 3, 3))) == 2
    assert cover.tree.measure == pytest.approx(2 * 4**3 / 6, rel=0.25)


def test_faces_are_the_tetrahedra_of_the_corners():
    """On a lattice: of each tetrahedron of s voxels the s (s + 1) (s + 2) / 6 cubes that it meets."""
    own = voxelise(four(f"{{ points = {CORNERS}, faces = {CLOSED} }}"), 64, depth=1)
    assert own.tree.count == 4 * (32 * 33 * 34 // 6)


@pytest.mark.parametrize("name", ["menger-sponge", "koch-curve", "sierpinski-triangle"])
def test_cells_without_a_stated_figure_stay_boxes(name):
    shape = ifs.shape(name)
    assert level_of(subject(shape), shape, 2) is None


def test_a_stated_box_stays_a_box():
    shape = triangle('"box"')
    assert level_of(subject(shape), shape, 1) is None
    assert black_of(voxelise(shape, 64, depth=1)).sum() == 3 * 32**2


def test_a_complex_is_filled_as_the_shape():
    shape = ifs.shape("sierpinski-tetrahedron")
    whole = ifs.initial(shape.topology, shape.system, shape.control)
    assert voxelise(whole, 50, depth=2).tree == voxelise(shape, 50, depth=2).tree
    finer = ifs.refined(whole, 1)
    assert voxelise(finer, 50, depth=1).tree == voxelise(shape, 50, depth=2).tree


@pytest.mark.parametrize(("level", "resolution"), [(1, 150), (4, 300)])
def test_predictions_are_of_the_figures(level, resolution):
    shape = ifs.shape("sierpinski-tetrahedron")
    told = estimate(shape, resolution, depth=level)
    tree = voxelise(shape, resolution, depth=level).tree
    assert 1 / 1.5 < told.voxels / tree.count < 1.5
    assert 1 / 1.5 < told.triangles / (2 * faces_of(tree)) < 1.5
