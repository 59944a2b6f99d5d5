"""Predictions of voxelisations, against voxelisations, and budgets."""

import re

import numpy as np
import pytest
from dense.cover import cover
from dense.surface import surface

import automata
import ifs
from export import skin, write_part
from export.voxels.estimate import Budget, OverBudget, Prediction, estimate, faces_of
from export.voxels.voxelise import voxelise

FACTOR = 1.5
ON_A_GRID = ("koch-curve", "menger-sponge", "sierpinski-tetrahedron", "sierpinski-triangle")
GRIDS = [
    *((name, 150) for name in automata.builtin_names()),
    *((name, n) for name in ON_A_GRID for n in (81, 243)),
]


@pytest.mark.parametrize(("name", "resolution"), GRIDS)
def test_predictions_are_right_within_a_factor(name, resolution):
    shape = ifs.shape(name)
    found = voxelise(shape, resolution)
    told = estimate(shape, resolution)
    faces = faces_of(found.tree)
    assert found.tree.count / FACTOR <= told.voxels <= found.tree.count * FACTOR
    assert faces / FACTOR <= told.triangles / 2 <= faces * FACTOR
    assert told.memory >= found.tree.nbytes / 2
    assert told.pitch == pytest.approx(found.pitch, rel=1e-12)


@pytest.mark.parametrize("name", ["menger-sponge", "sierpinski-tetrahedron", "doo-sabin-patch"])
def test_predicted_files_and_meshes_are_those_written(name, tmp_path):
    shape = ifs.shape(name)
    told = estimate(shape, 81)
    mesh = skin(voxelise(shape, 81).tree)
    assert told.triangles == pytest.approx(len(mesh.faces), rel=0.02)
    assert mesh.vertices.nbytes + mesh.faces.nbytes <= told.mesh_memory
    for kind, size in told.files.items():
        write_part(mesh, tmp_path / f"part.{kind}")
        assert size / 2 <= (tmp_path / f"part.{kind}").stat().st_size <= 1.2 * size


def test_a_lattice_that_the_grid_fits_is_predicted_by_one_that_it_fits():
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    shape = ifs.shape("sierpinski-tetrahedron", control=np.array(corners))
    told = estimate(shape, 1024)
    assert told.voxels == pytest.approx(4**10, rel=1e-6)
    assert faces_of(voxelise(shape, 256).tree) == pytest.approx(estimate(shape, 256).triangles / 2, rel=0.02)


def test_the_prediction_that_is_used_is_announced():
    told: list[Prediction] = []
    found = voxelise(
        ifs.shape("menger-sponge"),
        5000,
        depth=1,
        budget=Budget(10**5, exceeded="coarsen"),
        predicted=told.append,
    )
    assert [each.resolution for each in told] == [found.resolution]
    assert told[0] == found.prediction
    assert found.resolution < 60
    voxelise(ifs.shape("koch-curve"), 30, predicted=told.append)
    assert told[1].resolution == 30


def test_the_sponge_is_predicted_far_ahead():
    told = estimate(ifs.shape("menger-sponge"), 729)
    assert 20**6 / 2 <= told.voxels <= 20**6 * 2


@pytest.mark.parametrize("depth", [0, 1, 2])
def test_levels_grow_like_solids(depth):
    shape = ifs.shape("menger-sponge")
    told = estimate(shape, 243, depth=depth)
    assert told.voxels == pytest.approx(20**depth * (243 // 3**depth) ** 3, rel=0.5)


def test_faces_are_half_the_triangles_of_the_exact_surface():
    shape = ifs.shape("menger-sponge")
    mesh = surface(cover(shape, 9).voxels, "exact")
    assert len(mesh.faces) == 2 * faces_of(voxelise(shape, 9).tree)


def test_a_budget_refuses_with_numbers():
    shape = ifs.shape("menger-sponge")
    with pytest.raises(OverBudget) as raised:
        voxelise(shape, 20_000, budget=Budget(voxels=10**6))
    wrong = raised.value
    assert wrong.prediction.voxels > 10**9
    assert wrong.fits is not None
    assert re.search(
        r"20000 takes about .* voxels where 1e\+06 voxels are allowed; a resolution of", str(wrong)
    )
    found = voxelise(shape, wrong.fits, budget=Budget(voxels=10**6))
    assert found.tree.count < 2 * 10**6


@pytest.mark.parametrize(
    "limits", [{"voxels": 5000}, {"triangles": 40_000}, {"memory": 10**6}, {"file": 2 * 10**6}]
)
def test_a_budget_coarsens_and_says_so(limits):
    shape = ifs.shape("doo-sabin-patch")
    found = voxelise(shape, 300, budget=Budget(**limits, exceeded="coarsen"))
    assert found.asked == 300
    assert found.resolution < 300
    assert found.prediction is not None
    assert not Budget(**limits).broken(found.prediction)
    assert found.prediction.resolution == found.resolution


def test_a_budget_that_is_kept_changes_nothing():
    shape = ifs.shape("koch-curve")
    found = voxelise(shape, 100, budget=Budget(voxels=10**6, memory=10**9))
    assert found.resolution == found.asked == 100
    assert found.tree == voxelise(shape, 100).tree


def test_no_resolution_fits_an_impossible_budget():
    with pytest.raises(OverBudget, match="allow more"):
        voxelise(ifs.shape("koch-curve"), 100, budget=Budget(memory=1, exceeded="coarsen"))


@pytest.mark.parametrize("wrong", [{"voxels": 0}, {"memory": -1}, {"exceeded": "hope"}])
def test_senseless_budgets_are_refused(wrong):
    with pytest.raises(ValueError, match="budget"):
        Budget(**wrong)


def test_a_prediction_reads_as_one_line():
    told = Prediction(10, 0.5, 1234, 5678, 2_500_000, 999, {"stl": 12_300_000_000})
    assert str(told) == (
        "about 1.2e+03 voxels of 0.5 mm and 5.7e+03 triangles; memory 2.5 MB and 999 B for the mesh; "
        "files: stl 12.3 GB"
    )
