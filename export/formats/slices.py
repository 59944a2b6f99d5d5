"""Slices of a tree for printers that harden layer after layer: pictures or outlines, and a manifest."""

import contextlib
import json
import math
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from importlib.metadata import version

import numpy as np
from jaxtyping import Int64

from export.formats.archive import zip_archive
from export.formats.atomic import whole_file, whole_folder
from export.formats.deflate import zlib_stream
from export.formats.endings import UnsupportedFormat, ending_of
from export.formats.layers import CellBox, Picture, cell_box, layers
from export.formats.scene import check_recipe
from trees.tree import Tree

FORMATS = ("png", "svg")
MOST_PIXELS, MOST_LAYERS = 2**30, 10**6
MOST_BITS = 60
THINNEST = Fraction(1, 1000)  # of a layer: what is left above the others, and is no layer
MANIFEST = "manifest.json"
Progress = Callable[[str, float], None]
Put = Callable[[str, bytes], None]


class WrongSlices(ValueError):
    """A set that cannot be sliced so: empty, not in space, too large, or a layer height that is none."""


def write_slices(
    tree: Tree,
    path: str | os.PathLike[str],
    format: str = "png",
    layer_height: float | None = None,
    recipe: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> int:
    """Write the layers of a set in space (mm), from the bottom up, to a .zip archive, else to a folder.

    Layer i lies between i and i + 1 times `layer_height` (by default the edge of a cell) above the lowest
    cell, and shows the cells at half its height; the last layer the highest cells at most. "png" are pictures
    of one bit a pixel, white where the set is, a pixel a cell; "svg" are outlines in mm along the borders of
    cells, closed loops to be filled by even and odd. Both show the box around the set seen from above: x to
    the right, y upwards. `manifest.json` says how high layers and how large pixels are, where the low corner
    of the box lies, and in which order the files come. One layer is kept at a time.

    The answer is the number of layers. Whole or not at all; the same arguments give the same bytes. Raises
    `UnsupportedFormat` for another format or ending, `WrongSlices`, `WrongRecipe`, and `OSError`, of which
    `FileExistsError` for a folder that is not empty.

    >>> import tempfile, zipfile
    >>> from trees import full, unit_cube
    >>> place = Path(tempfile.mkdtemp()) / "cube.zip"
    >>> write_slices(full(unit_cube(3), bits=2), place, "svg", layer_height=0.5)
    2
    >>> zipfile.ZipFile(place).namelist()
    ['manifest.json', '000000.svg', '000001.svg']
    """
    if not isinstance(tree, Tree):
        raise WrongSlices(f"slices are of a trees.Tree, found a {type(tree).__name__}: voxelise it first")
    if format not in FORMATS:
        raise UnsupportedFormat(f"slices as {format!r}: write {', '.join(FORMATS)}")
    ending = ending_of(path)
    check_recipe(recipe or {})
    if ending not in ("", ".zip"):
        raise UnsupportedFormat(f"{path}: write .zip, or a folder whose name has no ending")
    if tree.dimension != 3:
        raise WrongSlices(f"slices of a set of dimension {tree.dimension}: 3 is needed")
    if tree.bits > MOST_BITS:
        raise WrongSlices(f"cells of {tree.bits} bits an axis: at most {MOST_BITS}; take a coarser tree")
    box = cell_box(tree)
    if box is None:
        raise WrongSlices("the set is empty: there is nothing to slice")
    height = tree.cell_size if layer_height is None else _length(layer_height)
    cells = _heights(tree, box, height)
    picture_of = _png if format == "png" else _svg
    told = _manifest(tree, box, format, height, len(cells), recipe or {})
    with _opened(path, ending == ".zip", stored=format == "png") as put:
        put(MANIFEST, told)
        last, content = -1, b""
        pictures = layers(tree, box, np.unique(cells))
        for number, cell in enumerate(cells.tolist()):
            if cell != last:
                last, content = cell, picture_of(next(pictures), tree.cell_size)
            put(_name(number, format), content)
            if progress is not None:
                progress("layers", (number + 1) / len(cells))
    return len(cells)


def _length(height: object) -> float:
    if isinstance(height, bool) or not isinstance(height, (int, float, Fraction, np.number)):
        raise WrongSlices(f"the layer height is a length above 0 mm, found {height!r}")
    return float(height)


def _heights(tree: Tree, box: CellBox, height: float) -> Int64[np.ndarray, " layers"]:
    """The z of the cells in the middle of each layer, in exact arithmetic."""
    if not (math.isfinite(height) and height > 0):
        raise WrongSlices(f"the layer height is a length above 0 mm, found {height}")
    step = Fraction(height) / Fraction(tree.cell_size)
    tall = int(box.sides[2])
    count = max(1, math.ceil(tall / step - THINNEST))
    if count > MOST_LAYERS:
        raise WrongSlices(f"{_many(count)} layers of {height} mm: at most {MOST_LAYERS}; take higher layers")
    pixels = int(box.sides[0]) * int(box.sides[1])
    if pixels > MOST_PIXELS:
        raise WrongSlices(f"layers of {pixels} cells: at most {MOST_PIXELS}; take a coarser tree")
    middles = [min(math.floor((2 * layer + 1) * step / 2), tall - 1) for layer in range(count)]
    return np.array(middles, dtype=np.int64) + box.low[2]


def _many(count: int) -> str:
    return str(count) if count < 10**12 else "more than 10^12"


def _name(number: int, format: str) -> str:
    return f"{number:06d}.{format}"


def _manifest(
    tree: Tree, box: CellBox, format: str, height: float, count: int, recipe: Mapping[str, str]
) -> bytes:
    width, depth, tall = box.sides.tolist()
    pitch = tree.cell_size
    told = {
        "format": "bcifs slices/1",
        "application": f"bcifs {version('bcifs')}",
        "unit": "mm",
        "layer_height": height,
        "layers": count,
        "order": "from the bottom up",
        "files": [_name(0, format), _name(count - 1, format)],
        "shown": "the cells at half the height of the layer",
        "pixel_size": [pitch, pitch],
        "pixels": [width, depth],
        "rows": "from the largest y down, x rising within a row",
        "size": [width * pitch, depth * pitch, tall * pitch],
        "origin": [x + low * pitch for x, low in zip(tree.origin, box.low.tolist(), strict=True)],
        "recipe": {key: recipe[key] for key in sorted(recipe)},
    }
    return (json.dumps(told, indent=1) + "\n").encode()


@contextlib.contextmanager
def _opened(path: str | os.PathLike[str], archive: bool, stored: bool) -> Iterator[Put]:
    """A function that writes an entry, or a file of the folder."""
    if archive:
        with whole_file(path) as file, zip_archive(file) as add:
            yield lambda name, content: add(name, [content], stored=stored and name != MANIFEST)
        return
    with whole_folder(path) as folder:

        def put(name: str, content: bytes) -> None:
            (folder / name).write_bytes(content)

        yield put


def _png(picture: Picture, pitch: float) -> bytes:
    """A picture of one bit a pixel, the last row on top, with the number of pixels to a metre."""
    rows, columns = picture.shape
    packed = np.zeros((rows, 1 + (columns + 7) // 8), dtype=np.uint8)
    packed[:, 1:] = np.packbits(picture[::-1], axis=1)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", columns, rows, 1, 0, 0, 0, 0))]
    density = round(1000 / pitch) if pitch > 1e-6 else 0
    if density:
        chunks.append((b"pHYs", struct.pack(">IIB", density, density, 1)))
    chunks += [(b"IDAT", zlib_stream(packed.tobytes())), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


def _svg(picture: Picture, pitch: float) -> bytes:
    """The outlines as one path, to a millionth of a millimetre."""
    from export.formats import slices_kernels as kernels

    flipped = np.pad(picture[::-1], 1)
    corners, sizes = kernels.outlines(flipped, kernels.corner_count(flipped))
    down, across = (_texts(count, pitch) for count in picture.shape)
    room = len(sizes) * 2 + len(corners) * (2 + across[2] + down[2])
    out = np.empty(room, dtype=np.uint8)
    used = kernels.path(corners, sizes, *across[:2], *down[:2], out)
    height, width = (_number(count * pitch) for count in picture.shape)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}"><path fill-rule="evenodd" d="'.encode()
        + out[:used].tobytes()
        + b'"/></svg>\n'
    )


def _texts(count: int, pitch: float) -> tuple[np.ndarray, Int64[np.ndarray, " ends"], int]:
    """The places of the borders of so many cells as text, where each begins, and the longest of them."""
    raw = [_number(place * pitch).encode() for place in range(count + 1)]
    ends = np.cumsum([0, *map(len, raw)], dtype=np.int64)
    return np.frombuffer(b"".join(raw), dtype=np.uint8), ends, max(map(len, raw))


def _number(length: float) -> str:
    text = f"{length:.6f}".rstrip("0").rstrip(".")
    return text or "0"
