"""The part made from the voxels that cover an attractor."""

import numpy as np
import pytest

import ifs
from export import Budget, OverBudget, make_part, skin, voxelise
from export.part import TooThick
from export.voxels.frame import TOLERANCE, lattice_resolution
from trees import Tree, to_points


def chaos_game(shape: ifs.Shape, count: int) -> np.ndarray:
    """Points of the attractor in mm, by random infinite addresses: independent of pieces and boxes."""
    rng = np.random.default_rng(7)
    pieces = {shape.system.shape: np.repeat(shape.control[None], count, axis=0)}
    for _ in range(60):
        smaller: dict[str, list[np.ndarray]] = {}
        for cell, controls in pieces.items():
            state = shape.system.states[cell]
            chosen = rng.integers(len(state.labels), size=len(controls))
            for label, (operator, target) in enumerate(zip(state.operators, state.targets, strict=True)):
                moved = np.einsum("jk,cjd->ckd", operator, controls[chosen == label])
                smaller.setdefault(target, []).append(moved)
        pieces = {cell: np.concatenate(parts) for cell, parts in smaller.items()}
    places = np.concatenate([controls[:, 0] for controls in pieces.values()])
    return np.pad(places, ((0, 0), (0, 3 - places.shape[1])))


def inside(tree: Tree, points: np.ndarray) -> np.ndarray:
    """Whether points lie in closed black voxels, widened by the stated tolerance."""
    places = (points - tree.origin) / tree.cell_size
    found = np.zeros(len(points), dtype=bool)
    for slack in np.stack(np.meshgrid(*[(-TOLERANCE, TOLERANCE)] * 3), axis=-1).reshape(-1, 3):
        found |= tree.holds_cells(np.floor(places + slack).astype(int))
    return found


def centres(tree: Tree) -> np.ndarray:
    return np.array(tree.origin) + (to_points(tree) + 0.5) * tree.cell_size


@pytest.mark.parametrize(("level", "genus"), [(1, 5), (2, 81), (3, 1409), (4, 26433)])
def test_menger_levels_are_exact(level, genus):
    part = make_part(ifs.shape("menger-sponge"), size=1.0, depth=level)
    assert part.report.ok
    assert part.report.genus == (genus,)
    assert part.report.volume == pytest.approx((20 / 27) ** level, rel=1e-9)
    assert part.tree.count == 20**level


def test_the_limit_of_the_sponge_on_its_own_grid_is_the_sponge_of_that_level():
    shape = ifs.shape("menger-sponge")
    assert voxelise(shape, 27).tree == voxelise(shape, 27, depth=3).tree


def test_a_lattice_is_found_only_where_there_is_one():
    assert lattice_resolution(ifs.shape("menger-sponge"), 3) == 27
    assert lattice_resolution(ifs.shape("koch-curve"), 3) is None
    assert lattice_resolution(ifs.shape("sierpinski-tetrahedron"), 2) is None


def test_a_thickened_curve_is_a_ball_swept_over_it():
    from scipy.spatial import KDTree

    shape = ifs.shape("koch-curve")
    radius = 3.0
    part = make_part(shape, size=60, thickness=2 * radius, resolution=120)
    pitch = part.tree.cell_size
    points = chaos_game(shape, 20_000) * (60 / 90)
    directions = np.random.default_rng(3).normal(size=points.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # A mesh with edges of a voxel stands for the curve, and each voxel of the part for its centre.
    reach = radius - 1.5 * np.sqrt(3) * pitch
    assert part.report.ok
    assert inside(part.tree, points + reach * directions).all()
    distance, _ = KDTree(points).query(centres(part.tree))
    assert distance.max() <= radius + np.sqrt(3) * pitch


def test_smooth_and_exact_surfaces_share_their_triangles():
    shape = ifs.shape("doo-sabin-patch")
    solid = make_part(shape, thickness=3.0, resolution=40)
    exact = make_part(shape, thickness=3.0, resolution=40, style="exact")
    assert solid.tree == exact.tree
    assert exact.report.volume == pytest.approx(surface_volume(skin(exact.tree, "exact")), rel=1e-12)
    assert solid.report.genus == exact.report.genus == (0,)
    assert solid.report.volume == pytest.approx(exact.report.volume, rel=0.15)


def surface_volume(mesh: ifs.Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("td,td->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"size": -1.0}, "size is above 0"),
        ({"thickness": float("nan")}, "thickness is 0 mm or more"),
        ({"resolution": 0}, "resolutions go from 1"),
        ({"depth": -1}, "depth is 0 or more"),
    ],
)
def test_senseless_numbers_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        make_part(ifs.shape("koch-curve"), **options)


def test_too_much_is_refused_before_any_work():
    sponge = ifs.shape("menger-sponge")
    with pytest.raises(OverBudget, match=r"a resolution of \d+ fits") as caught:
        make_part(sponge, resolution=5000)
    assert caught.value.prediction.triangles > 10**8
    with pytest.raises(OverBudget):
        make_part(sponge, resolution=5000, thickness=1.0)
    coarser = make_part(sponge, resolution=5000, budget=Budget(triangles=100_000, exceeded="coarsen"))
    assert 2_000 < len(coarser.mesh.faces) < 200_000
    assert int(coarser.recipe["Resolution"]) < 400


def test_too_thick_is_refused():
    with pytest.raises(TooThick, match="a smaller one"):
        make_part(ifs.shape("menger-sponge"), resolution=50, thickness=2000.0)


def test_progress_rises_to_one():
    told: list[tuple[str, float]] = []
    make_part(ifs.shape("menger-sponge"), resolution=40, progress=lambda *step: told.append(step))
    shares = [share for stage, share in told if stage == "voxels"]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert [*dict.fromkeys(stage for stage, _ in told)] == ["voxels", "surface", "check"]
