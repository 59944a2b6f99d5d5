"""Meshes from 3MF files: all that the build names, at its place."""

import io
import math
import posixpath
import zipfile
import zlib
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np
from jaxtyping import Float

from export.formats.damage import Damaged, shown
from export.formats.scene import moved
from export.formats.threemf_skim import RUNS, Take, feed
from ifs.mesh import Mesh

UNITS = {"micron": 0.001, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
RELATIONS = "_rels/.rels"
RATIO, SMALL = 250, 1 << 26  # an entry beyond 64 MiB that is packed more tightly than that is no mesh
PIECE = 1 << 20
DEEPEST = 64
MOST_TRIANGLES = 1 << 28
MOST_PARTS = 1_000_000

Transform = Float[np.ndarray, "4 4"]


@dataclass
class _Object:
    """What an object of a model part holds: numbers of its mesh, or parts by file, name and place."""

    line: int
    points: array = field(default_factory=lambda: array("d"))
    corners: array = field(default_factory=lambda: array("q"))
    parts: list[tuple[str, str, Transform]] = field(default_factory=list)


@dataclass
class _Model:
    """A model part as it stands."""

    scale: float = 1.0
    objects: dict[str, _Object] = field(default_factory=dict)
    items: list[tuple[str, str, Transform]] = field(default_factory=list)


def read_3mf(content: bytes) -> Mesh:
    """The triangles that the build of a 3MF file names, each at its place, in mm, as one mesh.

    Components of other model parts (the production extension) are followed. Document types, which can grow
    without end, are refused, and so are entries that grow to more than 250 times their size. Raises
    `Damaged`.
    """
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OverflowError) as error:
        what = f"this is no zip archive, or it is cut ({error}): a 3MF file is one"
        raise Damaged(f"the end of {len(content)} bytes", what) from None
    with archive:
        return _Package(archive).mesh()


class _Package:
    """The archive, and the model parts that were read."""

    def __init__(self, archive: zipfile.ZipFile):
        self.archive = archive
        self.models: dict[str, _Model] = {}
        self.points: list[np.ndarray] = []
        self.faces: list[np.ndarray] = []
        self.sizes: dict[tuple[str, str], tuple[int, int]] = {}
        self.vertices = 0

    def mesh(self) -> Mesh:
        first = self._first()
        model = self._model(first)
        items = [(file or first, name, transform) for file, name, transform in model.items]
        sizes = [self._size(file, name, 0, "the build") for file, name, _ in items]
        if sum(parts for parts, _ in sizes) > MOST_PARTS or sum(count for _, count in sizes) > MOST_TRIANGLES:
            raise Damaged(
                f"{first} in the archive",
                f"components within components grow without end: more than {MOST_PARTS} parts or "
                f"{MOST_TRIANGLES} triangles",
            )
        for file, name, transform in items:
            self._put(file, name, transform)
        if not self.faces:
            raise Damaged(f"{first} in the archive", "its build names no object with triangles")
        scale = model.scale
        return Mesh(np.concatenate(self.points) * scale, np.concatenate(self.faces))

    def _size(self, file: str, name: str, depth: int, by: str) -> tuple[int, int]:
        """How many parts and triangles an object is with all that is in it."""
        if (file, name) in self.sizes:
            return self.sizes[file, name]
        if depth > DEEPEST:
            raise Damaged(f"{file} in the archive", "components within components without end")
        found = self._model(file).objects.get(name)
        if found is None:
            raise Damaged(f"{file} in the archive", f"{by} names the object {shown(name)}, which is missing")
        parts, triangles = 1, len(found.corners) // 3
        for inner, part, _ in found.parts:
            more = self._size(inner or file, part, depth + 1, f"object {name}")
            parts, triangles = parts + more[0], triangles + more[1]
        self.sizes[file, name] = parts, triangles
        return parts, triangles

    def _put(self, file: str, name: str, transform: Transform) -> None:
        """Add an object and what is in it."""
        found = self._model(file).objects[name]
        where = f"{file} in the archive, line {found.line}"
        if found.corners:
            points = np.frombuffer(found.points, dtype=np.float64).reshape(-1, 3)
            faces = np.frombuffer(found.corners, dtype=np.int64).reshape(-1, 3)
            wrong = (faces < 0) | (faces >= len(points))
            if wrong.any():
                triangle, corner = np.argwhere(wrong)[0]
                what = f"triangle {triangle} of object {name} names vertex {faces[triangle, corner]}"
                raise Damaged(where, f"{what} of {len(points)}")
            placed = moved(Mesh(points, faces), transform)
            self.points.append(placed.vertices)
            self.faces.append(placed.faces + self.vertices)
            self.vertices += len(points)
        for inner, part, at in found.parts:
            self._put(inner or file, part, transform @ at)

    def _first(self) -> str:
        """The name of the entry with the model."""
        names = self.archive.namelist()
        if RELATIONS in names:
            found: list[str] = []

            def start(name: str, given: dict[str, str]) -> None:
                if given.get("Type", "").endswith("/3dmodel"):
                    found.append(given.get("Target", "").lstrip("/"))

            _parse(self.archive, RELATIONS, start, expat.ParserCreate(), lambda *_: None)
            if found and found[0] in names:
                return found[0]
        models = sorted(name for name in names if name.lower().endswith(".model"))
        if not models:
            raise Damaged("the archive", f"no model was found among its {len(names)} entries")
        return models[0]

    def _model(self, name: str) -> _Model:
        name = posixpath.normpath(name.lstrip("/"))
        if name not in self.models:
            if name not in self.archive.namelist():
                raise Damaged("the archive", f"the entry {shown(name)} is named, but missing")
            self.models[name] = _read_model(self.archive, name)
        return self.models[name]


def _read_model(archive: zipfile.ZipFile, entry: str) -> _Model:
    model = _Model()
    current: list[_Object] = []

    def start(name: str, given: dict[str, str]) -> None:
        match name:
            case "vertex":
                if current:
                    current[0].points.extend((_real(given, "x"), _real(given, "y"), _real(given, "z")))
            case "triangle":
                if current:
                    current[0].corners.extend((_whole(given, "v1"), _whole(given, "v2"), _whole(given, "v3")))
            case "component":
                if current:
                    current[0].parts.append(_part(given))
            case "item":
                model.items.append(_part(given))
            case "object":
                current[:] = [_Object(parser.CurrentLineNumber)]
                if "id" not in given:
                    raise _Wrong("an object without id")
                model.objects[given["id"]] = current[0]
            case "model":
                unit = given.get("unit", "millimeter")
                if unit not in UNITS:
                    raise _Wrong(f"one of the units {', '.join(UNITS)} was expected, found {shown(unit)}")
                model.scale = UNITS[unit]

    def take(name: str, rows: np.ndarray) -> None:
        if current:
            (current[0].points if name == "vertices" else current[0].corners).frombytes(rows.tobytes())

    parser = expat.ParserCreate()
    _parse(archive, entry, start, parser, take)
    return model


class _Wrong(ValueError):
    """What is wrong with an element; the parser knows where."""


def _real(given: dict[str, str], key: str) -> float:
    try:
        return float(given[key])
    except (KeyError, ValueError):
        raise _Wrong(f"a number {key} was expected, found {shown(given.get(key, 'none'))}") from None


def _whole(given: dict[str, str], key: str) -> int:
    try:
        found = int(given[key][:25])
    except (KeyError, ValueError):
        found = -1
    if not 0 <= found < 2**62:
        what = f"{key}, the number of a vertex, was expected, found {shown(given.get(key, 'none'))}"
        raise _Wrong(what)
    return found


def _part(given: dict[str, str]) -> tuple[str, str, Transform]:
    """The file (where it is another one), the name and the place of an object."""
    if "objectid" not in given:
        raise _Wrong("an item without objectid")
    transform = np.eye(4)
    if "transform" in given:
        words = given["transform"].split()
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers = []
        if len(numbers) != 12 or not all(map(math.isfinite, numbers)):
            raise _Wrong(f"a transform of 12 numbers was expected, found {shown(given['transform'])}")
        transform[:3] = np.array(numbers).reshape(4, 3).T
    file = next((value for key, value in given.items() if key.endswith(":path")), "")
    return file, given["objectid"], transform


def _parse(archive: zipfile.ZipFile, entry: str, start, parser, take: Take) -> None:
    """Call `start(local name, attributes)` for each element of an XML entry, and `take` as `feed` does."""
    opened = -1

    def begin(name: str, given: dict[str, str]) -> None:
        nonlocal opened
        if name in RUNS:
            opened = parser.CurrentByteIndex
        start(name.rpartition(":")[2], given)

    def refuse(*_: object) -> None:
        raise _Wrong("a document type, which 3MF forbids: entities could grow without end")

    parser.StartElementHandler = begin
    parser.StartDoctypeDeclHandler = refuse
    parser.buffer_text = True
    where = f"{entry} in the archive"
    try:
        feed(parser, _pieces(archive, entry), lambda: opened, take)
    except expat.ExpatError as error:
        what = f"XML was expected: {expat.ErrorString(error.code)}, at column {error.offset}"
        raise Damaged(f"{where}, line {error.lineno}", what) from None
    except _Wrong as error:
        raise Damaged(f"{where}, line {parser.CurrentLineNumber}", str(error)) from None
    except Damaged:
        raise
    except (LookupError, ValueError) as error:  # of the encoding that the first line names
        raise Damaged(f"{where}, line 1", f"XML in UTF-8 was expected ({error})") from None


def _pieces(archive: zipfile.ZipFile, entry: str) -> Iterator[bytes]:
    """The content of an entry, unpacked as it is asked for."""
    where = f"{entry} in the archive"
    size, packed = 0, archive.getinfo(entry).compress_size
    try:
        with archive.open(entry) as file:
            while piece := file.read(PIECE):
                size += len(piece)
                if size > SMALL and size > RATIO * packed:
                    what = f"{packed} bytes grow to more than {size}: no mesh is packed so tightly"
                    raise Damaged(where, what, "do not open it")
                yield piece
    except Damaged:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, ValueError) as error:
        what = f"{packed} packed bytes cannot be unpacked ({error}): the file is damaged"
        raise Damaged(where, what) from None
    except RuntimeError:  # zipfile says so of what needs a password
        raise Damaged(where, "it is encrypted", "save it without a password") from None
