"""The part made from the voxels that cover an attractor."""

import sys

import numpy as np
import pytest

import ifs
from export import (
    Budget,
    DoesNotFit,
    Grading,
    OverBudget,
    Part,
    Prediction,
    Printable,
    Region,
    TooThick,
    TooThin,
    make_part,
    prepare,
    skin,
    voxelise,
)
from export.voxels.frame import TOLERANCE, lattice_resolution
from subdivision.schemes import bezier, tensor
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
        ({"pitch": 0.0}, "pitch is above 0"),
        ({"pitch": 1.0, "resolution": 20}, "two answers"),
        ({"style": "round"}, "'smooth' or 'exact', found 'round'"),
        ({"contacts": "glue"}, "one of join, separate; found 'glue'"),
        ({"thickness": 3.0, "thicken_by": "cube"}, "one of ball, box; found 'cube'"),
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


TILTS = [(0.0, 0.0), (0.3, 0.1), (1.0, 0.5)]


def sheet(tilt: tuple[float, float]) -> ifs.Shape:
    """A flat square of 10 mm seen from above, that rises by so much to the right and to the back."""
    corners = np.array([[x, y, tilt[0] * x + tilt[1] * y] for x in (0.0, 10.0) for y in (0.0, 10.0)])
    return ifs.shape(tensor(bezier(1), bezier(1)), control=corners)


def sides_of(part: Part, tilt: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """How far the vertices above and below the middle of a sheet are from its plane, in pitches."""
    normal = np.array([-tilt[0], -tilt[1], 1.0])
    away = part.mesh.vertices @ (normal / np.linalg.norm(normal)) / part.tree.cell_size
    away = away[(np.abs(part.mesh.vertices[:, :2] - 5) < 3.5).all(axis=1)]
    return away[away > 0], -away[away < 0]


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("across", [1, 1.5, 2, 3.3, 5.5, 10])
def test_a_flat_wall_is_as_thick_as_asked(tilt, across):
    shape = sheet(tilt)
    pitch = float(np.ptp(np.array(ifs.bounding_box(shape)), axis=0).max()) / 40
    part = make_part(shape, resolution=40, thickness=across * pitch)
    above, below = sides_of(part, tilt)
    least, most = above.min() + below.min(), above.max() + below.max()
    assert part.report.ok
    if across >= 2:
        assert across - 0.25 <= least <= most <= across + 0.25
        assert not part.steps
        return
    assert across - 0.25 <= least <= most <= across + 1.07
    told = {step.name: step.figures for step in part.steps}["thickness"]
    assert told["least"] <= least * pitch
    assert most * pitch <= told["most"] + 0.07 * pitch


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("across", [2, 4.5])
def test_a_box_makes_slanted_walls_thicker(tilt, across):
    """Along a unit normal n the box of side t reaches `t (|n_1| + |n_2| + |n_3|)`."""
    shape = sheet(tilt)
    pitch = float(np.ptp(np.array(ifs.bounding_box(shape)), axis=0).max()) / 40
    part = make_part(shape, resolution=40, thickness=across * pitch, thicken_by="box")
    normal = np.abs([*tilt, 1.0]) / np.linalg.norm([*tilt, 1.0])
    above, below = sides_of(part, tilt)
    assert above.mean() + below.mean() == pytest.approx(across * normal.sum(), abs=0.25)
    assert part.recipe["Thickness"].endswith("by a box")


def test_thin_walls_raise_the_resolution_or_are_refused(monkeypatch):
    monkeypatch.setattr(sys.modules["export.prepare"], "RESOLUTION", 20)
    shape = sheet((0.0, 0.0))
    fine = make_part(shape, thickness=0.5)
    assert fine.tree.cell_size == pytest.approx(0.25)
    assert [step.name for step in fine.steps] == ["resolution"]
    with pytest.raises(TooThin, match=r"thickness of 0\.2 mm is less than a voxel of 0\.25 mm") as caught:
        make_part(shape, thickness=0.2, resolution=40)
    assert caught.value.resolution == 100
    with pytest.raises(TooThin, match=r"a drain of 0\.1 mm"):
        make_part(shape, resolution=40, printable=Printable(drain=0.1))


def test_a_lattice_stays_one_where_short_lengths_refine_it():
    sponge = ifs.shape("menger-sponge")
    prepared = prepare(sponge, size=27, depth=2, printable=Printable(hollow=1.0))
    assert prepared.cover.resolution % 9 == 0
    assert prepared.tree.cell_size <= 0.5
    assert prepared.steps[0].figures["resolution"] == prepared.cover.resolution


def test_a_hollow_drained_part_has_the_volume_of_a_shell():
    """A cube of 20 mm with walls of 2 mm, less a hole through one of them, on a base of 3 mm."""
    cube = block()
    asked = Printable(hollow=2.0, drain=1.0, base=3.0, fit=(20.0, 20.0, 23.0))
    part = make_part(cube, depth=0, resolution=40, printable=asked)
    assert part.report.ok
    hole = 5 * 4 * 0.125  # discs of 5 voxels of 0.125 mm^3, through four layers
    assert part.report.volume == pytest.approx(20**3 - 16**3 + 3 * 400 - hole)
    assert [step.name for step in part.steps] == ["hollow", "base", "drain", "fit"]
    assert {"Hollow", "Base", "Drain", "Fit"} <= part.recipe.keys()
    assert part.report.components == 1
    assert not [note for note in part.report.notes if note.kind == "trapped_voids"]


def block() -> ifs.Shape:
    """The box of the sponge at level 0: a cube of 20 mm."""
    return ifs.shape("menger-sponge").scaled(20 / 54)


def test_a_smooth_part_keeps_its_surface_where_voxels_are_what_they_were():
    shape = sheet((0.3, 0.1))
    plain = make_part(shape, resolution=40, thickness=3.0)
    holed = make_part(shape, resolution=40, thickness=3.0, printable=Printable(hollow=0.8, drain=0.6))
    assert holed.report.ok
    assert holed.report.volume < 0.75 * plain.report.volume
    kept = {tuple(vertex) for vertex in holed.mesh.vertices.tolist()}
    same = sum(tuple(vertex) in kept for vertex in plain.mesh.vertices.tolist())
    assert same > 0.95 * len(plain.mesh.vertices)


def test_a_turned_part_is_the_same_part_turned():
    shape = sheet((0.3, 0.1))
    plain = make_part(shape, resolution=40, thickness=2.0)
    turned = make_part(shape, resolution=40, thickness=2.0, printable=Printable(turn="x"))
    assert turned.report.ok
    assert turned.report.volume == pytest.approx(plain.report.volume, rel=1e-6)
    sides, other = (np.subtract(part.report.high, part.report.low) for part in (plain, turned))
    np.testing.assert_allclose(np.sort(other), np.sort(sides), atol=1e-9)
    assert other[2] == pytest.approx(sides[0])


def test_what_does_not_fit_is_refused_or_turned():
    shape = sheet((0.0, 0.0))
    options = {"resolution": 40, "thickness": 1.0}
    with pytest.raises(DoesNotFit, match="turned otherwise it does"):
        make_part(shape, **options, printable=Printable(fit=(2.0, 12.0, 12.0)))
    part = make_part(shape, **options, printable=Printable(fit=(2.0, 12.0, 12.0), turn="fit"))
    assert part.report.high[0] - part.report.low[0] <= 2.0
    with pytest.raises(DoesNotFit, match=r"at \d\d % of its size it would") as caught:
        make_part(shape, **options, printable=Printable(fit=(8.0, 8.0, 8.0), turn="fit"))
    assert 0.6 < caught.value.fit.scale < 0.8


@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_separate_contacts_are_kept_apart(tmp_path, style):
    """Two cubes of 10 mm that share an edge."""
    maps = '[[maps]]\nscale = "1/2"\ntranslation = [0, 0, 0]\n'
    maps += '[[maps]]\nscale = "1/2"\ntranslation = ["1/2", "1/2", 0]\n'
    control = "[control]\npoints = [[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]]\n"
    file = tmp_path / "cubes.toml"
    file.write_text(f'format = "bcifs/1"\nname = "Cubes"\n{maps}{control}')
    options = {"depth": 1, "resolution": 8, "style": style}
    joined, parted = (make_part(ifs.shape(file), **options, contacts=rule) for rule in ("join", "separate"))
    assert joined.report.ok
    assert parted.report.ok
    assert (joined.report.components, parted.report.components) == (1, 2)
    assert parted.recipe["Contacts"] == "separate"


def test_the_prediction_is_told_once():
    told: list[Prediction] = []
    budget = Budget(triangles=100_000, exceeded="coarsen")
    part = make_part(ifs.shape("menger-sponge"), resolution=5000, budget=budget, predicted=told.append)
    assert [str(found.resolution) for found in told] == [part.recipe["Resolution"]]


def test_blocks_are_told_and_go_with_no_steps() -> None:
    sponge = ifs.shape("menger-sponge")
    made = make_part(sponge, size=27, resolution=81, depth=1, grading=Grading(2))
    assert made.report.ok
    (told,) = made.steps
    assert told.figures["side"] == pytest.approx(2 / 3)
    assert told.figures["before"] == pytest.approx(20 * 9**3)
    assert told.figures["after"] == pytest.approx(made.report.volume)
    with pytest.raises(ValueError, match="blocks would undo"):
        make_part(sponge, resolution=27, depth=0, grading=Grading(2), printable=Printable(hollow=6))
    with pytest.raises(ValueError, match="misses the part"):
        make_part(sponge, depth=1, grading=Grading(2, (Region((-9, -9, -9), (-1, -1, -1)),)))
    with pytest.raises(ValueError, match="less than 2 blocks"):
        make_part(sponge, size=27, resolution=27, thickness=2, grading=Grading(4))


def test_thickened_blocks_keep_their_volume() -> None:
    """Blocks of a thick shell: black where the field is at most 0 in their middles."""
    patch = ifs.shape("catmull-clark-patch")
    fine = make_part(patch, size=40, resolution=80, thickness=4)
    coarse = make_part(patch, size=40, resolution=80, thickness=4, grading=Grading(4))
    assert coarse.report.ok
    assert coarse.report.triangles < fine.report.triangles / 8
    assert coarse.report.volume == pytest.approx(fine.report.volume, rel=0.05)


def test_merged_squares_and_kept_edges_of_parts() -> None:
    sponge = ifs.shape("menger-sponge")
    plain, merged = (make_part(sponge, size=27, depth=2, merge=merge) for merge in (False, True))
    assert merged.report.triangles < plain.report.triangles
    assert (merged.report.volume, merged.report.genus) == (pytest.approx(plain.report.volume), (81,))
    koch = ifs.shape("koch-curve")
    sharp = make_part(koch, size=40, resolution=80, thickness=4, thicken_by="box", features=30)
    assert sharp.report.ok
    assert sharp.mesh.vertices[:, 2].max() == pytest.approx(2, abs=1e-3)
    with pytest.raises(ValueError, match="exact style"):
        make_part(koch, thickness=4, merge=True)
    with pytest.raises(ValueError, match="give a thickness"):
        make_part(sponge, features=30)
