"""Parts before independent judges: manifold3d, admesh, lib3mf and PrusaSlicer take them as they are."""

import re
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path
from typing import Any

import lib3mf
import manifold3d
import numpy as np
import pytest
from scipy import ndimage

import ifs
from automata import Automaton
from bcifs.demo import PARTS
from export import Part, make_part, write_part
from export.meshing.joining import join_contacts
from ifs.maps.maps import affine
from ifs.maps.plain import from_maps
from subdivision.schemes import b_spline, cesaro, corner_cutting, interpolation, takagi, tensor
from trees import to_array

SLICER = shutil.which("prusa-slicer")
ADMESH = shutil.which("admesh")
REPAIRS = re.compile(r"repair|open_edges|edges_fixed|facets_(added|removed|reversed)|degenerate", re.I)
# Said of parts with islands in the air, which are what such automata are.
EMPTY_LAYERS = re.compile(r"print warning: Empty layer between .*?orientation on the bed\.", re.S)
COARSE = "--nozzle-diameter 1 --layer-height 0.8 --first-layer-height 0.8 --perimeters 1 --fill-density 0"
QUICK = (2, 4, 7)  # a curve, a plain IFS of space and a surface
SEEDS = range(20)
SAMPLED = 2000  # triangles and vertices that are read back one by one


def plain(rng: np.random.Generator, axes: int) -> Automaton:
    """Affine maps that turn, shear and shrink."""
    maps = []
    for _ in range(rng.integers(2, 6)):
        linear = rng.normal(size=(axes, axes))
        linear *= rng.uniform(0.3, 0.7) / np.linalg.norm(linear, 2)
        maps.append(affine(linear.round(3).tolist(), rng.normal(size=axes).round(3).tolist()))
    return from_maps(maps)


def curve(rng: np.random.Generator) -> Automaton:
    """A family of curves, and a member of it with random coefficients."""

    def between(low: float, high: float) -> Fraction:
        return Fraction(int(rng.integers(round(64 * low), round(64 * high) + 1)), 64)

    match rng.integers(5):
        case 0:
            return takagi(between(-0.6, 0.8))
        case 1:
            return corner_cutting(between(0.1, 0.4), between(0.1, 0.4))
        case 2:
            return interpolation([(x, 0) for x in range(4)], [between(-0.5, 0.5) for _ in range(3)])
        case 3:
            return cesaro(int(rng.integers(20, 90)))
        case _:
            return b_spline(int(rng.integers(2, 4)))


def random_shape(seed: int) -> ifs.Shape:
    """In turn a plain IFS of the plane, one of space, a curve in space and a surface."""
    rng = np.random.default_rng(seed)
    kind = seed % 4
    if kind < 2:
        return ifs.shape(plain(rng, 2 + kind))
    found = curve(rng) if kind == 2 else tensor(curve(rng), curve(rng))
    return ifs.shape(found, control=rng.uniform(0, 60, (found.cells[found.shape].points, 3)))


def random_part(seed: int) -> Part:
    thickness = 4.5 if seed // 4 % 2 else 0.0
    style = ("exact", "smooth")[seed // 8 % 2]
    return make_part(random_shape(seed), size=60, resolution=40, thickness=thickness, style=style)


def run(*command: str | Path) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, errors="replace", timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_automata_are_many_and_differ():
    shapes = [random_shape(seed) for seed in SEEDS]
    assert len({shape.control.tobytes() + str(shape.system.states).encode() for shape in shapes}) == len(
        shapes
    )
    assert len({shape.name for shape in shapes}) >= 6


def judge_cells(part: Part) -> None:
    """The shells and the genus of the report, by labels and counts on the dense array of the joined cells."""
    black = to_array(join_contacts(part.tree))
    for axis in range(3):
        used = np.flatnonzero(black.any(axis=tuple(other for other in range(3) if other != axis)))
        black = black.take(range(used[0], used[-1] + 1), axis)
    black = np.pad(black, 1)
    parts, holes = labels(black), labels(~black) - 1
    assert part.report.components == parts + holes
    assert part.report.euler == 2 * euler(black)
    assert sum(1 - (genus or 0) for genus in part.report.genus) == euler(black)
    if part.recipe["Surface"] == "exact":
        assert part.report.volume == pytest.approx(black.sum() * part.tree.cell_size**3, rel=1e-9)


def labels(black: np.ndarray) -> int:
    found: Any = ndimage.label(black)
    return found[1]


def euler(black: np.ndarray) -> int:
    """Vertices - edges + faces - cells of the closed cubes; the array has a white border."""
    total = 0
    for axes in np.ndindex(2, 2, 2):
        touched = black
        for axis in np.flatnonzero(axes):
            touched = touched | np.roll(touched, 1, axis)
        total -= (-1) ** sum(axes) * int(touched.sum())
    return total


def judge_manifold3d(part: Part) -> None:
    mesh = manifold3d.Mesh64(part.mesh.vertices, part.mesh.faces.astype(np.uint64))
    solid = manifold3d.Manifold(mesh)
    assert solid.status() == manifold3d.Error.NoError
    assert (solid.num_vert(), solid.num_tri()) == (part.report.vertices, part.report.triangles)
    assert solid.genus() == 1 - part.report.euler // 2
    assert solid.volume() == pytest.approx(part.report.volume, rel=1e-9)
    assert solid.surface_area() == pytest.approx(part.report.area, rel=1e-9)
    assert len(solid.decompose()) == part.report.components


def judge_lib3mf(part: Part, path: Path) -> None:
    model: Any = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    assert objects.MoveNext()
    mesh = objects.GetCurrentMeshObject()
    assert not objects.MoveNext()
    assert mesh.IsManifoldAndOriented()
    faces, vertices = part.mesh.faces, part.mesh.vertices
    assert (mesh.GetTriangleCount(), mesh.GetVertexCount()) == (len(faces), len(vertices))
    rng = np.random.default_rng(0)
    some, others = rng.integers(len(faces), size=SAMPLED), rng.integers(len(vertices), size=SAMPLED)
    read = np.array([tuple(mesh.GetTriangle(int(i)).Indices) for i in some])
    assert np.array_equal(read, faces[some])
    places = np.array([tuple(mesh.GetVertex(int(i)).Coordinates) for i in others])
    np.testing.assert_allclose(places, vertices[others], rtol=2**-23, atol=1e-6)


def judge_admesh(part: Part, path: Path) -> None:
    said = run(str(ADMESH), path)
    for what in ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Facets reversed",
                 "Backwards edges", "Normals fixed", "Total disconnected facets"):  # fmt: skip
        numbers = re.search(rf"{what} *:((?: +\d+)+)", said)
        assert numbers, said
        assert set(numbers[1].split()) == {"0"}, said
    assert re.search(rf"Number of parts *: *{part.report.components} ", said), said
    volume = re.search(r"Volume *: *([\d.]+)", said)
    assert volume
    assert float(volume[1]) == pytest.approx(part.report.volume, rel=1e-3)


def judge_slicer(part: Part, path: Path) -> None:
    facts = run(str(SLICER), "--info", path)
    assert "manifold = yes" in facts
    assert not REPAIRS.search(facts), facts
    assert re.search(rf"number_of_facets = +{part.report.triangles}\b", facts), facts
    assert re.search(rf"number_of_parts = +{part.report.components}\b", facts), facts
    for low, axis in zip(part.report.low, "xyz", strict=True):
        found = re.search(rf"min_{axis} = (\S+)", facts)
        assert found
        assert float(found[1]) == pytest.approx(low, abs=1e-4)
    gcode = path.with_suffix(".gcode")
    said = run(str(SLICER), "--export-gcode", *COARSE.split(), "-o", gcode, path)
    if part.report.components > 1:
        said = EMPTY_LAYERS.sub("", said)
    assert not REPAIRS.search(said), said
    assert gcode.stat().st_size > 10_000


@pytest.mark.parametrize(
    "name",
    [*(pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in [*SEEDS, *PARTS])],
)
def test_the_judges_take_the_part_as_it_is(name, tmp_path):
    """One test a part, for the part is made once."""
    part = make_part(ifs.shape(name), **PARTS[name]) if name in PARTS else random_part(name)
    assert part.report.ok, part.report.faults
    path = tmp_path / "part.3mf"
    write_part(part.mesh, path, part.recipe)
    write_part(part.mesh, path.with_suffix(".stl"))
    judge_cells(part)
    judge_manifold3d(part)
    judge_lib3mf(part, path)
    if ADMESH:
        judge_admesh(part, path.with_suffix(".stl"))
    if SLICER:
        judge_slicer(part, path)
    missing = [tool for tool, found in (("admesh", ADMESH), ("prusa-slicer", SLICER)) if not found]
    if missing:
        pytest.skip(f"{' and '.join(missing)} not installed; the other judges take the part")


@pytest.mark.parametrize("fault", ["hole", "turned", "twice"])
def test_the_judges_would_tell_of_a_fault(fault, tmp_path):
    part = make_part(ifs.shape("menger-sponge"), size=27, depth=1)
    faces = part.mesh.faces.copy()
    match fault:
        case "hole":
            faces = faces[:-1]
        case "turned":
            faces[5] = faces[5, ::-1]
        case _:
            faces = np.vstack([faces, faces[:1]])
    broken = ifs.Mesh(part.mesh.vertices, faces)
    path = tmp_path / "broken.3mf"
    write_part(broken, path)
    write_part(broken, path.with_suffix(".stl"))
    wrong = Part(broken, part.tree, part.report, part.recipe)
    with pytest.raises(AssertionError):
        judge_manifold3d(wrong)
    with pytest.raises(AssertionError):
        judge_lib3mf(wrong, path)
    if ADMESH:
        with pytest.raises(AssertionError):
            judge_admesh(wrong, path.with_suffix(".stl"))
    if SLICER:
        with pytest.raises(AssertionError):
            judge_slicer(wrong, path)
