"""Voxels that cover attractors: against the dense cover, points of the chaos game, and finer evaluations."""

import math
from fractions import Fraction

import numpy as np
import pytest
from dense.cover import cover
from scipy.ndimage import binary_dilation
from scipy.spatial import KDTree

import automata
import ifs
from automata.language import forbidding
from export.voxels import piece_walk
from export.voxels.forms import affine_rules, forms_of
from export.voxels.frame import subject
from export.voxels.masses import masses
from export.voxels.voxelise import Cover, voxelise
from ifs.certificates.bounds import sample
from ifs.maps.maps import affine, similarity
from ifs.maps.plain import from_maps
from ifs.orbits import points
from ifs.orbits.attractor import points_in_chunks
from trees import to_array, to_points

BUILTIN = automata.builtin_names()
LIGHT = [name for name in BUILTIN if name not in ("fractal-patch", "catmull-clark-patch")]


def drawn(shape: ifs.Shape, count: int) -> np.ndarray:
    """Points of the chaos game in mm, with z = 0 for plane shapes."""
    found = np.concatenate(list(points(shape, count, seed=11)))
    return np.pad(found, ((0, 0), (0, 3 - found.shape[1])))


def farthest_outside(found: Cover, places: np.ndarray) -> float:
    """How far the farthest point is from the closed black voxels, in mm, up to half a pitch."""
    scaled = (places - np.array(found.tree.origin)) / found.pitch
    least = np.full(len(places), np.inf)
    for step in np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3):
        cells = np.clip(np.floor(scaled + step), 0, 2**found.tree.bits - 1)
        for near in (cells, np.floor(scaled).clip(0)):
            gap = np.linalg.norm(np.maximum(np.maximum(near - scaled, scaled - near - 1), 0), axis=1)
            black = found.tree.holds_cells(near.astype(np.int64))
            least = np.minimum(least, np.where(black, gap, np.inf))
    return float(least.max()) * found.pitch


def random_shape(seed: int) -> ifs.Shape:
    """Affine maps that turn, shear and shrink, in the plane or in space."""
    rng = np.random.default_rng(seed)
    axes = 2 + seed % 2
    maps = []
    for _ in range(2 + seed % 4):
        linear = rng.normal(size=(axes, axes))
        linear *= rng.uniform(0.2, 0.7) / np.linalg.norm(linear, 2)
        maps.append(affine(linear.round(6).tolist(), rng.normal(size=axes).round(6).tolist()))
    return ifs.shape(from_maps(maps))


@pytest.mark.parametrize("name", LIGHT)
def test_the_voxels_are_those_of_the_dense_cover_or_next_to_them(name):
    """Boxes around pieces are others, mostly smaller: no voxel is away from those of the dense cover."""
    shape = ifs.shape(name)
    dense = cover(shape, 40)
    found = voxelise(shape, 40)
    assert found.size == dense.voxels.filled.shape
    assert found.tree.origin == pytest.approx(dense.voxels.origin, abs=1e-11)
    ours = to_array(found.tree)[tuple(slice(n) for n in found.size)]
    assert not (ours & np.logical_not(binary_dilation(dense.voxels.filled, np.ones((3, 3, 3))))).any()
    assert not (dense.voxels.filled & np.logical_not(binary_dilation(ours, np.ones((3, 3, 3))))).any()
    assert found.tree.count <= 1.02 * dense.voxels.count
    assert found.distance <= dense.distance * (1 + 1e-6)


@pytest.mark.parametrize("name", ["menger-sponge", "sierpinski-tetrahedron", "koch-curve"])
def test_pieces_whose_boxes_are_the_same_give_the_same_voxels(name):
    shape = ifs.shape(name)
    dense = cover(shape, 40)
    ours = to_array(voxelise(shape, 40).tree)[tuple(slice(n) for n in dense.voxels.filled.shape)]
    assert np.array_equal(ours, dense.voxels.filled)


@pytest.mark.parametrize("name", BUILTIN)
def test_a_million_points_of_the_chaos_game_are_covered(name):
    shape = ifs.shape(name)
    found = voxelise(shape, 61)
    number = 0
    for chunk in points(shape, 1_000_000, seed=11):
        number += len(chunk)
        places = np.pad(chunk, ((0, 0), (0, 3 - chunk.shape[1])))
        cells = np.floor((places - np.array(found.tree.origin)) / found.pitch).astype(np.int64)
        missed = places[~found.tree.holds_cells(cells.clip(0, 2**found.tree.bits - 1))]
        assert not len(missed) or farthest_outside(found, missed) <= found.outer
    assert number == 1_000_000
    assert found.outer < 1e-6 * found.pitch


@pytest.mark.parametrize("seed", range(4))
def test_random_systems_are_covered_within_the_stated_distances(seed):
    shape = random_shape(seed)
    found = voxelise(shape, 50)
    assert farthest_outside(found, drawn(shape, 50_000)) <= found.outer
    assert_near(shape, found)


@pytest.mark.parametrize("name", BUILTIN)
def test_the_distance_is_that_of_an_evaluation_eight_times_finer(name):
    shape = ifs.shape(name)
    assert_near(shape, voxelise(shape, 4 if name == "fractal-patch" else 10), 8)


def assert_near(shape: ifs.Shape, found: Cover, finer: int = 3) -> None:
    """All corners of black voxels are near points that are dense in the attractor; some are at a pitch."""
    fineness = found.pitch / finer
    dense = np.concatenate(list(points_in_chunks(shape, tolerance=fineness)))
    dense = np.pad(dense, ((0, 0), (0, 3 - dense.shape[1])))
    cells = to_points(found.tree).astype(float)
    steps = np.stack(np.meshgrid(*[(0, 1)] * 3), axis=-1).reshape(-1, 3)
    corners = np.array(found.tree.origin) + found.pitch * np.unique(
        (cells[:, None] + steps).reshape(-1, 3), axis=0
    )
    gap = KDTree(dense).query(corners)[0].max()
    assert gap <= found.inner + fineness
    assert found.pitch / 2 <= gap
    assert found.inner <= 2 * math.sqrt(3) * found.pitch * (1 + 1e-6)


def test_strict_covers_hold_points_on_the_faces_of_voxels():
    shape = ifs.shape("menger-sponge")
    found = voxelise(shape, 27, snap=0)
    assert found.outer == 0
    assert found.tree.count > 8000
    assert farthest_outside(found, drawn(shape, 100_000)) == 0


@pytest.mark.parametrize("level", [1, 2, 3])
def test_levels_of_the_sponge_are_exact(level):
    shape = ifs.shape("menger-sponge")
    found = voxelise(shape, 3**level, depth=level)
    assert found.tree.count == 20**level
    assert found.tree == voxelise(shape, 3**level).tree
    fine = voxelise(shape, 54, depth=level)
    assert fine.tree.count == 20**level * (54 // 3**level) ** 3
    assert fine.inner == pytest.approx(math.sqrt(3) * (1 + 54 / 3**level), rel=1e-6)


@pytest.mark.parametrize("name", ["koch-curve", "corner-cutting", "menger-sponge", "doo-sabin-patch"])
@pytest.mark.parametrize("depth", [None, 2])
def test_blocks_and_one_go_give_the_same_voxels(name, depth, monkeypatch):
    shape = ifs.shape(name)
    whole = voxelise(shape, 50, depth=depth, way="walk")
    monkeypatch.setattr(piece_walk, "FLAT", 9)
    monkeypatch.setattr(piece_walk, "BLOCK", 9)
    parts = voxelise(shape, 50, depth=depth, way="walk")
    assert parts.tree == whole.tree
    assert parts.tree.count > 50 or depth


def test_grids_beyond_a_dense_array_are_filled_in_blocks():
    half = Fraction(1, 2)
    maps = [similarity(half, [half * (i == axis) for axis in range(3)]) for i in range(4)]
    found = voxelise(ifs.shape(from_maps(maps)), 2**11, way="walk")
    assert 3 * found.tree.bits > piece_walk.FLAT
    assert found.tree.count == 4**11


def test_smaller_parts_give_fewer_voxels():
    shape = ifs.shape("doo-sabin-patch")
    coarse, fine = voxelise(shape, 30), voxelise(shape, 30, part=1 / 4)
    assert fine.tree.count < coarse.tree.count
    assert not fine.tree - coarse.tree
    assert fine.inner < coarse.inner
    assert fine.inner <= 1.25 * math.sqrt(3) * fine.pitch * (1 + 1e-6)
    assert farthest_outside(fine, drawn(shape, 100_000)) <= fine.outer


def test_the_cube_of_the_tree_says_where_the_voxels_are():
    found = voxelise(ifs.shape("takagi-curve"), pitch=0.3)
    assert found.tree.size == 0.3 * 2.0**found.tree.bits
    assert found.size[2] == 1
    assert set(to_points(found.tree)[:, 2].tolist()) == {0}
    assert found.tree.origin[2] == -0.15


def test_maps_that_hardly_shrink_need_many_levels():
    maps = [similarity(Fraction(19, 20), [0]), similarity(Fraction(19, 20), [Fraction(1, 20)])]
    found = voxelise(ifs.shape(from_maps(maps)), 1000)
    assert found.tree.count == 1000
    assert found.size == (1000, 1, 1)


def test_surfaces_over_control_meshes_come_through_the_same_door():
    corners = np.array([[x, y, z] for x in (0, 40) for y in (0, 40) for z in (0, 40)])
    cube = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    surface = ifs.surface(corners, cube)
    found = voxelise(surface, 20)
    mesh = ifs.smooth(corners, cube, depth=4)
    assert farthest_outside(found, mesh.vertices) <= found.outer
    gap = KDTree(mesh.vertices).query(
        np.array(found.tree.origin) + found.pitch * (to_points(found.tree) + 0.5)
    )[0]
    assert gap.max() <= found.inner
    assert voxelise(surface.complex(), 20).tree == found.tree


def test_mixed_shapes_are_covered():
    from ifs.mixtures import mixed
    from subdivision.schemes import bezier, takagi

    arch = np.array([[0.0, 0], [40, 60], [80, 0]])
    smooth, rough = (ifs.shape(curve, control=arch) for curve in (bezier(2), takagi()))
    shape = mixed([smooth, rough], bezier(1))
    found = voxelise(shape, 90)
    assert farthest_outside(found, drawn(shape, 50_000)) <= found.outer


def test_systems_of_a_language_are_covered():
    """Words without the letter 1 twice in a row: fewer points than all words make."""
    half = Fraction(1, 2)
    maps = [similarity(half, place) for place in ([0, 0], [half, 0], [0, half])]
    whole = ifs.shape(from_maps(maps))
    some = ifs.shape(forbidding(from_maps(maps), ["1 1"]))
    found = voxelise(some, 64)
    assert len(some.system.states) > len(whole.system.states)
    assert farthest_outside(found, drawn(some, 50_000)) <= found.outer
    everything = voxelise(whole, pitch=found.pitch)
    assert found.tree.count < 0.9 * everything.tree.count
    assert_near(some, found)


def test_masses_of_voxels_are_those_of_points():
    shape = ifs.shape("sierpinski-triangle")
    found = voxelise(shape, 20)
    ours = masses(shape, found)
    assert ours.amounts.sum() == pytest.approx(1, abs=1e-9)
    cells = np.floor((drawn(shape, 200_000) - np.array(found.tree.origin)) / found.pitch).astype(int)
    keys = {tuple(cell): place for place, cell in enumerate(to_points(found.tree).tolist())}
    counts = np.bincount([keys[tuple(cell)] for cell in cells.tolist()], minlength=len(keys)) / len(cells)
    assert np.abs(counts - ours.amounts).sum() / 2 <= ours.error + 0.03


def test_progress_rises_to_one_and_an_interruption_stops_the_work(monkeypatch):
    monkeypatch.setattr(piece_walk, "_STEPS", 5000)
    shares: list[float] = []
    voxelise(ifs.shape("menger-sponge"), 60, progress=lambda stage, share: shares.append(share))
    assert shares == sorted(shares)
    assert len(shares) > 20
    assert shares[0] == 0
    assert shares[-1] == 1

    def stop(stage, share):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        voxelise(ifs.shape("menger-sponge"), 60, progress=stop)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "either a resolution"),
        ({"resolution": 5, "pitch": 1.0}, "either a resolution"),
        ({"resolution": 0}, "1 or more"),
        ({"pitch": float("nan")}, "above 0 mm"),
        ({"resolution": 3_000_000}, "or more is possible"),
        ({"resolution": 8, "depth": -1}, "depth is 0 or more"),
        ({"resolution": 8, "part": 0.0}, "from 1/64 to 1"),
        ({"resolution": 8, "snap": 0.1}, "snap"),
        ({"resolution": 8, "way": "fast"}, "auto, walk, lattice"),
    ],
)
def test_senseless_numbers_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        voxelise(ifs.shape("koch-curve"), **options)


def test_grids_of_too_many_blocks_are_refused(monkeypatch):
    monkeypatch.setattr(piece_walk, "FLAT", 9)
    monkeypatch.setattr(piece_walk, "WALKED", 20)
    with pytest.raises(piece_walk.GridTooLarge, match="128 x 111 x 105 voxels is too large to be walked"):
        voxelise(ifs.shape("sierpinski-tetrahedron"), 128)


@pytest.mark.parametrize(
    ("model", "size"),
    [("koch-curve", 10), (ifs.shape("koch-curve"), 2.5), (ifs.shape("koch-curve"), "7")],
)
def test_what_is_no_shape_or_number_is_refused(model, size):
    with pytest.raises(TypeError):
        voxelise(model, size)


def test_control_points_that_are_not_finite_are_named():
    with pytest.raises(ValueError, match="control point 1 is not finite"):
        voxelise(ifs.shape("koch-curve", control=np.array([[0, 0], [math.nan, 1], [2, 0]])), 10)


def test_forms_hold_the_attractor_and_its_pieces():
    """Points of every cell lie in the box of its form, and rules carry coordinates to those of the piece."""
    for name in ("koch-curve", "menger-sponge", "doo-sabin-patch", "catmull-clark-patch"):
        found = subject(ifs.shape(name))
        forms = forms_of(found.system, found.boxes, found.roots)
        rules = affine_rules(found.system, forms)
        columns = sample(found.system)
        for cell, state in found.system.states.items():
            form = forms[cell]
            for (target, matrix, shift), operator in zip(rules[cell], state.operators, strict=True):
                below = (columns[target][:-1] - forms[target].centre) @ forms[target].functionals
                here = ((operator @ columns[target])[:-1] - form.centre) @ form.functionals
                assert here == pytest.approx(shift + below @ matrix, abs=1e-9)
                if form.half is not None:
                    assert (np.abs(here) <= form.half + 1e-12).all()
                slow = form.slow
                assert np.abs(matrix[slow:, :slow]).max(initial=0) <= 1e-10


def test_points_and_higher_spaces_are_refused():
    point = ifs.shape(from_maps([similarity(Fraction(1, 2), [0, 0])]))
    with pytest.raises(ValueError, match="single point"):
        voxelise(point, 10)
    four = ifs.shape(from_maps([similarity(Fraction(1, 2), [b] * 4) for b in (0, 1)]))
    with pytest.raises(ValueError, match="1 to 3 coordinates"):
        voxelise(four, 10)
