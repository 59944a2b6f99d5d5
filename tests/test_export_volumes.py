"""Clouds from models and the files they leave in: closed forms, and other readers."""

import math
import struct
import subprocess
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista
import trimesh
from PIL import Image

import ifs
from bcifs.cloud import write_cloud
from export.files import UnsupportedFormat
from export.inside import EmptyModel, NotClosed, inside
from export.vapour import vapour
from export.volumes import write_volume
from ifs.measures.density import density
from ifs.measures.grid import Density, Grid, TooManyCells, grid_around
from ifs.measures.moments import WrongProbabilities

SYSTEM_PYTHON = Path("/usr/bin/python3")


def mesh_of(solid):
    return ifs.Mesh(np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces, dtype=np.int64))


def box(low, high):
    solid = trimesh.creation.box(bounds=[np.full(3, low), np.full(3, high)])
    return mesh_of(solid)


def centres(grid):
    return np.stack(np.indices(grid.size), axis=-1) * grid.pitch + grid.origin + grid.pitch / 2


def test_cells_inside_a_ball_are_those_within_its_radius():
    ball = trimesh.creation.icosphere(4, radius=10)
    grid = grid_around(np.full(3, -10.0), np.full(3, 10.0), 41, margin=1)
    found = inside(mesh_of(ball), grid)
    away = np.linalg.norm(centres(grid), axis=-1)
    nearest = np.linalg.norm(ball.triangles_center, axis=1).min()  # facets lie between these radii
    assert found[away < nearest].all()
    assert not found[away > 10].any()
    assert found.sum() * grid.cell == pytest.approx(ball.volume, rel=0.01)


def test_hollow_and_overlapping_bodies_are_counted_by_their_winding():
    grid = Grid(np.zeros(3), 1.0, (10, 10, 10))
    outer, inner = box(0, 10), box(2, 5)
    hollow = ifs.Mesh(
        np.concatenate([outer.vertices, inner.vertices]),
        np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)]),
    )
    assert inside(hollow, grid).sum() == 1000 - 27
    other = box(3, 8)
    both = ifs.Mesh(
        np.concatenate([inner.vertices, other.vertices]),
        np.concatenate([inner.faces, other.faces + len(inner.vertices)]),
    )
    assert inside(both, grid).sum() == 27 + 125 - 8
    assert inside(ifs.Mesh(other.vertices, other.faces[:, ::-1]), grid).sum() == 125
    # The centres of cells lie on the faces of this box: each column still has its whole length.
    assert inside(box(2.5, 5.5), grid).sum() == 27


def test_the_sponge_fills_the_cells_of_its_digits():
    found = inside(ifs.mesh(ifs.shape("menger-sponge"), 3), Grid(np.zeros(3), 1.0, (54, 54, 54)))
    digits = np.array([[n // 9, n // 3 % 3, n % 3] for n in range(27)]) == 1
    inner = digits[:, None, None].astype(int) + digits[None, :, None] + digits[None, None, :]
    filled = (inner < 2).all(axis=-1)
    assert np.array_equal(found, np.kron(filled, np.ones((2, 2, 2))).astype(bool))


def test_wrong_models_are_refused():
    good = box(0, 10)
    holed = ifs.Mesh(good.vertices, good.faces[1:])
    with pytest.raises(NotClosed, match="model 1 is not closed: 3 edges") as caught:
        vapour([good, holed])
    assert caught.value.edges == 3
    with pytest.raises(EmptyModel, match="model 0 has no faces"):
        vapour([ifs.Mesh(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int64))])
    with pytest.raises(EmptyModel, match="model 1 has no centre of a cell inside"):
        vapour([good, box(4.01, 4.02)], resolution=10)
    with pytest.raises(EmptyModel, match="no model"):
        vapour([])
    with pytest.raises(ValueError, match="model 0 is a str"):
        vapour(["bull.obj"])  # pyright: ignore
    with pytest.raises(TooManyCells):
        vapour([good, good], resolution=2000)
    with pytest.raises(WrongProbabilities, match="sum to 1; they sum to 2"):
        vapour([good, good], [1.0, 1.0], resolution=5)
    with pytest.raises(ValueError, match="resolution"):
        vapour([good], resolution=0)


def test_a_cloud_lies_between_its_models():
    told = []
    small, large = box(2, 8), box(0, 10)
    found = vapour(
        [small, large],
        [0.75, 0.25],
        resolution=20,
        progress=lambda message, share: told.append((message, share)),
    )
    opacity = found.density.amounts / found.density.grid.cell
    assert [model.sum() * found.density.grid.cell for model in found.models] == pytest.approx([216, 1000])
    assert np.allclose(opacity[found.models[0]], 1, atol=1e-14)
    assert (opacity[~found.models[1]] == 0).all()
    assert 216 < found.density.total < 1000
    assert np.allclose(found.density.centroid, 5, atol=found.density.grid.pitch / 2)
    assert opacity.max() <= 1
    for message in ("models", "sets"):
        shares = [share for name, share in told if name == message]
        assert shares == sorted(shares)
        assert shares[-1] == pytest.approx(1)
    alone = vapour([small, large], [0.0, 1.0], resolution=20)
    assert np.array_equal(alone.density.amounts > 0, found.models[1])


def test_one_model_is_perturbed_by_the_seed():
    ball = trimesh.creation.icosphere(3, radius=10)
    one, same, other = (vapour([ball], resolution=24, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.density.amounts, same.density.amounts)
    assert one.density.grid.size != other.density.grid.size or not np.array_equal(
        one.models[1], other.models[1]
    )
    assert one.recipe["Probabilities"] == "0.666667, 0.333333"
    assert one.recipe["Seed"] == "1"
    both = one.models[0] & one.models[1]
    opacity = one.density.amounts / one.density.grid.cell
    assert np.allclose(opacity[both], 1)
    # All words that end at a model's own cells weigh at least p_0^5, those of the ball's letter alone.
    assert opacity[one.models[0]].min() >= (2 / 3) ** 5 - 1e-12
    still = vapour([ball], resolution=24, amount=0.0)
    assert np.array_equal(still.models[0], still.models[1])


def test_solids_of_build123d_are_models():
    from build123d import Box, Cylinder

    found = vapour([Box(10, 10, 10), Cylinder(5, 10)], resolution=20)
    volumes = [model.sum() * found.density.grid.cell for model in found.models]
    assert volumes[0] == pytest.approx(1000)
    assert volumes[1] == pytest.approx(250 * math.pi, rel=0.02)


def example(size=(20, 150, 9)):
    random = np.random.default_rng(0)
    values = np.where(random.random(size) < 0.1, random.random(size), 0.0)
    values[:, :, : size[2] // 2] = 0
    return Density(Grid(np.array([1.0, -2.0, 3.0]), 0.5, size), values * 0.125)


def test_a_vtk_image_reads_back(tmp_path):
    made = example()
    write_volume(made, tmp_path / "a.vti", {"Seed": "7"})
    image = pyvista.read(tmp_path / "a.vti")
    assert image.spacing == (0.5, 0.5, 0.5)
    assert image.origin == (1.0, -2.0, 3.0)
    values = np.asarray(image.cell_data["density"]).reshape(made.grid.size, order="F")
    assert np.array_equal(values, (made.amounts * 8).astype(np.float32))
    assert list(image.field_data["bcifs:Seed"]) == ["7"]


class Reader:
    """The bytes of an OpenVDB file, in order."""

    def __init__(self, content):
        self.content, self.at = content, 0

    def take(self, form) -> Any:
        found = list(struct.unpack_from("<" + form, self.content, self.at))
        self.at += struct.calcsize("<" + form)
        return found[0] if len(found) == 1 else tuple(found)

    def raw(self, count):
        self.at += count
        return self.content[self.at - count : self.at]

    def text(self):
        return self.raw(self.take("I")).decode()

    def metadata(self):
        found = {}
        for _ in range(self.take("I")):
            key, kind = self.text(), self.text()
            assert kind == "string"
            found[key] = self.text()
        return found

    def mask(self, side):
        bits = np.unpackbits(np.frombuffer(self.raw(side**3 // 8), np.uint8), bitorder="little")
        return np.argwhere(bits.reshape(side, side, side))

    def values(self):
        assert self.take("B") == 0
        size = self.take("q")
        content = zlib.decompress(self.raw(size)) if size > 0 else self.raw(-size)
        return np.frombuffer(content, "<f4")


def read_vdb(path):
    """Name, metadata, the 18 numbers of the transform, and the active voxels by place."""
    reader = Reader(path.read_bytes())
    assert reader.take("qIIIB") == (0x56444220, 224, 10, 0, 1)
    reader.raw(36)
    assert set(reader.metadata()) == {"SHA-256"}
    assert reader.take("I") == 1
    name, kind, _ = reader.text(), reader.text(), reader.text()
    assert kind == "Tree_float_5_4_3"
    start, buffers, end = reader.take("qqq")
    assert (reader.at, len(reader.content)) == (start, end)
    assert reader.take("I") == 3
    metadata = reader.metadata()
    assert reader.text() == "UniformScaleTranslateMap"
    transform = reader.take("18d")
    assert reader.take("If") == (1, 0.0)
    assert reader.take("I") == 0
    leaves = []
    for _ in range(reader.take("I")):
        root = np.array(reader.take("iii"))
        upper = reader.mask(32)
        assert not len(reader.mask(32))
        assert not len(reader.values())
        for middle in upper:
            lower = reader.mask(16)
            assert not len(reader.mask(16))
            assert not len(reader.values())
            leaves += [(root + 128 * middle + 8 * leaf, reader.mask(8)) for leaf in lower]
    assert reader.at == buffers
    voxels = {}
    for corner, active in leaves:
        assert np.array_equal(reader.mask(8), active)
        voxels |= zip(map(tuple, (corner + active).tolist()), reader.values().tolist(), strict=True)
    assert reader.at == end
    return name, metadata, transform, voxels


@pytest.mark.parametrize("size", [(20, 150, 9), (4, 3, 4200)])
def test_an_openvdb_file_holds_the_grid(tmp_path, size):
    made = example(size)
    write_volume(made, tmp_path / "a.vdb", {"Seed": "7"}, name="smoke")
    name, metadata, transform, voxels = read_vdb(tmp_path / "a.vdb")
    assert name == metadata["name"] == "smoke"
    assert metadata["bcifs:Seed"] == "7"
    assert metadata["class"] == "fog volume"
    assert transform[:6] == (1.25, -1.75, 3.25, 0.5, 0.5, 0.5)  # the centre of the first cell, the pitch
    values = (made.amounts * 8).astype(np.float32)
    expected = {tuple(place): float(values[tuple(place)]) for place in np.argwhere(values).tolist()}
    assert voxels == expected
    first = (tmp_path / "a.vdb").read_bytes()
    write_volume(made, tmp_path / "a.vdb", {"Seed": "7"}, name="smoke")
    assert (tmp_path / "a.vdb").read_bytes() == first


def test_openvdb_itself_reads_the_grid(tmp_path):
    def system(code):
        return subprocess.run([SYSTEM_PYTHON, "-c", code], cwd=tmp_path, capture_output=True, text=True)

    if not SYSTEM_PYTHON.exists() or system("import pyopenvdb, numpy").returncode:
        pytest.skip("needs Debian's python3-openvdb")
    made = example((4, 3, 4200))
    write_volume(made, tmp_path / "a.vdb")
    code = (
        "import numpy, pyopenvdb; grid = pyopenvdb.read('a.vdb', 'density');"
        f"values = numpy.zeros({made.grid.size}, 'f4'); grid.copyToArray(values);"
        "numpy.save('a.npy', values);"
        "print(grid.activeVoxelCount(), grid.gridClass, *grid.transform.indexToWorld((-0.5, -0.5, -0.5)))"
    )
    answer = system(code)
    assert answer.returncode == 0, answer.stderr
    count = np.count_nonzero(made.amounts)
    assert answer.stdout.split() == [str(count), "fog", "volume", "1.0", "-2.0", "3.0"]
    assert np.array_equal(np.load(tmp_path / "a.npy"), (made.amounts * 8).astype(np.float32))


def test_an_empty_grid_and_a_plane_one_can_be_written(tmp_path):
    write_volume(Density(Grid(np.zeros(3), 1.0, (3, 3, 3)), np.zeros((3, 3, 3))), tmp_path / "a.vdb")
    assert read_vdb(tmp_path / "a.vdb")[3] == {}
    plane = density(ifs.shape("sierpinski-triangle"), 8)
    write_volume(plane, tmp_path / "b.vdb")
    _, _, transform, voxels = read_vdb(tmp_path / "b.vdb")
    assert transform[2] == 0
    assert sum(voxels.values()) * plane.grid.cell == pytest.approx(1, rel=1e-6)


def test_wrong_volumes_leave_no_file(tmp_path):
    made = example()
    with pytest.raises(UnsupportedFormat, match=r"write \.vdb, \.vti"):
        write_volume(made, tmp_path / "a.raw")
    endless = Density(made.grid, np.full(made.grid.size, np.inf))
    (tmp_path / "a.vdb").write_bytes(b"before")
    with pytest.raises(ValueError, match="not finite"):
        write_volume(endless, tmp_path / "a.vdb")
    with pytest.raises(FileNotFoundError):
        write_volume(made, tmp_path / "missing" / "a.vdb")
    assert [path.name for path in tmp_path.iterdir()] == ["a.vdb"]
    assert (tmp_path / "a.vdb").read_bytes() == b"before"


def test_a_picture_shows_paper_around_and_shadow_below(tmp_path):
    found = vapour([trimesh.creation.icosphere(3, radius=10), box(-7, 7)], resolution=24)
    write_cloud(found.density, tmp_path / "cloud.png", found.recipe)
    with Image.open(tmp_path / "cloud.png") as picture:
        assert picture.text["bcifs:Models"] == "2"  # pyright: ignore
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    height, width = pixels.shape[:2]
    assert np.abs(pixels[3, 3] - [0xFB, 0xFA, 0xF6]).max() <= 1
    above, below = pixels[height // 3, width // 2], pixels[3 * height // 4, width // 2]
    assert above.sum() > below.sum() + 60
    with pytest.raises(ValueError, match="not all 0"):
        write_cloud(Density(found.density.grid, np.zeros(found.density.grid.size)), tmp_path / "none.png")


def test_a_plane_picture_is_dark_where_the_mass_is(tmp_path):
    grid = Grid(np.zeros(2), 1.0, (2, 1))
    write_cloud(Density(grid, np.array([[1.0], [0.25]])), tmp_path / "two.png")
    with Image.open(tmp_path / "two.png") as picture:
        pixels = np.asarray(picture.convert("RGB"))
    height, width = pixels.shape[:2]
    assert pixels[height // 2, width // 4].tolist() == [0x1F, 0x4E, 0x6B]  # ink
    assert pixels[height // 2, 3 * width // 4].tolist() == [0x8D, 0xBA, 0xD6]  # clay: the root of a quarter


def test_the_gallery_cloud_lies_between_the_sponge_and_the_pebble():
    from gallery.vapour import build

    made = build()
    cell = made.density.grid.cell
    sponge, pebble = (float(model.sum() * cell) for model in made.models)
    assert sponge == pytest.approx(54**3 * (20 / 27) ** 2, rel=0.03)
    assert sponge < made.density.total < pebble
    assert np.allclose(made.density.centroid, 27, atol=made.density.grid.pitch / 2)
    assert np.allclose(made.density.amounts[made.models[0] & made.models[1]], cell)
