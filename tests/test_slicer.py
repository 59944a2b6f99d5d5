"""Every part of the demonstration goes through a slicer, which must find nothing to repair."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from dense.surface import surface
from dense.voxels import Voxels

import ifs
from bcifs.demo import PARTS
from export import make_part, write_part
from ifs import Mesh
from trees.topology import components

SLICER = shutil.which("prusa-slicer")
ADMESH = shutil.which("admesh")

needs_slicer = pytest.mark.skipif(SLICER is None, reason="prusa-slicer is not installed")
REPAIRS = re.compile(r"repair|open_edges|edges_fixed|facets_(added|removed|reversed)|degenerate", re.I)


def run(*command: str | Path) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, errors="replace", timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module", params=PARTS)
def part(request, tmp_path_factory) -> tuple[Path, int]:
    """A demo part as a 3MF file, with the number of its outer shells."""
    made = make_part(ifs.shape(request.param), **PARTS[request.param])
    assert made.report.ok, made.report.faults
    path = tmp_path_factory.mktemp("parts") / f"{request.param}.3mf"
    write_part(made.mesh, path, made.recipe)
    write_part(made.mesh, path.with_suffix(".stl"), made.recipe)
    return path, len(components(made.tree))


@pytest.mark.slow
@needs_slicer
def test_the_slicer_takes_the_part_as_it_is(part, tmp_path):
    path, components = part
    facts = run(SLICER, "--info", path)
    assert "manifold = yes" in facts
    assert not REPAIRS.search(facts), facts
    assert re.search(rf"number_of_parts\s*=\s*{components}\b", facts), facts
    gcode = tmp_path / "part.gcode"
    said = run(SLICER, "--export-gcode", "--support-material", "-o", gcode, path)
    assert not REPAIRS.search(said), said
    assert gcode.stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.skipif(ADMESH is None, reason="admesh is not installed")
def test_admesh_repairs_nothing(part):
    path, _ = part
    report = run(ADMESH, path.with_suffix(".stl"))
    for what in ("Edges fixed", "Facets removed", "Facets added", "Facets reversed", "Backwards edges"):
        found = re.search(rf"{what}\s*:\s*(\d+)", report)
        assert found is not None, report
        assert found[1] == "0", report


@needs_slicer
def test_the_slicer_would_tell_of_a_hole(tmp_path):
    cube = surface(Voxels(np.ones((1, 1, 1), dtype=bool), np.zeros(3), 10.0), "exact")
    path = tmp_path / "open.stl"
    write_part(Mesh(cube.vertices, cube.faces[:-1]), path)
    facts = run(SLICER, "--info", path)
    assert "manifold = no" in facts
    assert REPAIRS.search(facts)
