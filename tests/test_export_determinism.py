"""The same recipe gives the same bytes in every format, on one thread or several, in any process."""

import os
import subprocess
import sys

import pytest

WRITE_ALL = """
import hashlib, pathlib, sys
import export, ifs
from export.formats.tree_files import write_cells

folder = pathlib.Path(sys.argv[1])
flat = export.make_part(ifs.shape("takagi-curve"), size=40, thickness=2, resolution=80)
sponge = export.make_part(ifs.shape("sierpinski-tetrahedron"), size=40, resolution=40)
for name, part in (("flat", flat), ("tetrahedron", sponge)):
    for ending in (".3mf", ".stl", ".ply", ".obj", ".glb"):
        export.write_part(part.mesh, folder / (name + ending), part.recipe, name)
    for ending in (".vdb", ".htg"):
        write_cells(part.tree, folder / (name + ending))
    for kind in ("png", "svg"):
        export.write_slices(part.tree, folder / f"{name}-{kind}.zip", kind)
for path in sorted(folder.iterdir()):
    print(path.name, hashlib.sha256(path.read_bytes()).hexdigest())
"""


def written(folder, threads: int, seed: int) -> dict[str, str]:
    folder.mkdir()
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "PYTHONHASHSEED": str(seed)}
    command = [sys.executable, "-c", WRITE_ALL, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=280)
    assert done.returncode == 0, done.stderr
    return dict(line.split() for line in done.stdout.splitlines())


@pytest.mark.slow
def test_threads_and_processes_do_not_show(tmp_path):
    one = written(tmp_path / "one", threads=1, seed=0)
    assert len(one) == 18
    assert len(set(one.values())) == 18
    assert written(tmp_path / "two", threads=2, seed=12345) == one
