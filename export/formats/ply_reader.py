"""Meshes from PLY files: text, and binary of either byte order."""

from dataclasses import dataclass

import numpy as np

from export.formats.damage import Damaged, fans, shown
from ifs.mesh import Mesh

KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4",
    "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST = 1 << 20  # bytes of a head
LISTS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class Property:
    """A column; `length` is the type of the number of its entries where these are lists."""

    name: str
    kind: str
    length: str = ""


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    line: int
    properties: tuple[Property, ...]

    @property
    def lists(self) -> bool:
        return any(one.length for one in self.properties)


def read_ply(content: bytes) -> Mesh:
    """The faces of a PLY file as triangles. Elements other than vertices and faces are passed over.

    Raises `Damaged`.
    """
    order, elements, begin, line = _head(content)
    rest = _Text(content[begin:], line) if not order else _Binary(content, begin, order)
    points, faces = None, None
    for element in elements:
        rest.check_room(element)
        if element.name == "vertex":
            columns = [[one.name for one in element.properties].index(axis) for axis in "xyz"]
            points = rest.rows(element)[:, columns].astype(np.float64)
        elif element.name == "face":
            faces = rest.polygons(element)
        elif points is None or faces is None:
            rest.skip(element)
        if points is not None and faces is not None:
            return Mesh(points, faces)
    missing = "vertex" if points is None else "face"
    raise Damaged("the head", f'no "element {missing}" is announced: this file holds no mesh')


def _head(content: bytes) -> tuple[str, list[Element], int, int]:
    if content[:3] != b"ply":
        raise Damaged("line 1", f"'ply' was expected, found {shown(content[:50].splitlines()[0])}")
    at, number, order = 0, 0, None
    elements: list[Element] = []
    while True:
        end = content.find(b"\n", at, LONGEST)
        if end < 0:
            raise Damaged(f"after line {number}", '"end_header" was expected, the head does not end')
        number, line = number + 1, content[at:end].strip()
        at = end + 1
        words = line.decode("latin-1").split()
        match words:
            case ["end_header"]:
                break
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case ["format", name, _] if name in ORDERS:
                order = ORDERS[name]
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 19:
                elements.append(Element(name, int(count), number, ()))
            case ["property", "list", length, kind, name] if (
                elements and kind in KINDS and KINDS.get(length, "f")[0] in "iu"
            ):
                elements[-1] = _with(elements[-1], Property(name, KINDS[kind], KINDS[length]))
            case ["property", kind, name] if elements and kind in KINDS:
                elements[-1] = _with(elements[-1], Property(name, KINDS[kind]))
            case _:
                what = f"a format, an element, a property or end_header was expected, found {shown(line)}"
                raise Damaged(f"line {number}", what)
    if order is None:
        raise Damaged(f"line {number}", 'a line "format ascii 1.0" or of a binary format is missing')
    for element in elements:
        names = [one.name for one in element.properties]
        if element.name == "vertex" and (not {"x", "y", "z"} <= set(names) or element.lists):
            raise Damaged(
                f"line {element.line}", f"properties x, y, z of vertices were expected, found {names}"
            )
        if element.name == "face" and not any(one.length and one.name in LISTS for one in element.properties):
            what = f"a property list vertex_indices of faces was expected, found {names}"
            raise Damaged(f"line {element.line}", what)
    return order, elements, at, number


def _with(element: Element, found: Property) -> Element:
    return Element(element.name, element.count, element.line, (*element.properties, found))


def _corners(element: Element) -> int:
    return next(k for k, one in enumerate(element.properties) if one.length and one.name in LISTS)


def _too_few(element: Element, needed: int, left: int, unit: str) -> Damaged:
    what = f"{element.count} rows of {element.name} are announced, which take {needed} {unit} at least"
    return Damaged(f"line {element.line}", f"{what}; {left} are left: the file is cut or the number wrong")


class _Binary:
    """What stands behind the head, read element by element."""

    def __init__(self, content: bytes, at: int, order: str):
        self.content, self.at, self.order = content, at, order

    def check_room(self, element: Element) -> None:
        least = sum(np.dtype(one.length or one.kind).itemsize for one in element.properties)
        if element.count * least > len(self.content) - self.at:
            raise _too_few(element, element.count * least, len(self.content) - self.at, "bytes")

    def rows(self, element: Element) -> np.ndarray:
        kinds = [(f"f{k}", self.order + one.kind) for k, one in enumerate(element.properties)]
        table = np.frombuffer(self.content, np.dtype(kinds), element.count, self.at)
        self.at += table.nbytes
        return np.column_stack([table[name].astype(np.float64) for name, _ in kinds])

    def polygons(self, element: Element) -> np.ndarray:
        found = self._alike(element)
        if found is not None:
            return found
        corners, lengths = [], []
        which = _corners(element)
        for row in range(element.count):
            some = self._row(element, row, which)
            lengths.append(len(some))
            corners.append(some)
        return fans(np.concatenate(corners) if corners else [], np.array(lengths, dtype=np.int64))

    def skip(self, element: Element) -> None:
        if not element.lists:
            self.at += element.count * sum(np.dtype(one.kind).itemsize for one in element.properties)
            return
        for row in range(element.count):
            self._row(element, row, 0)

    def _row(self, element: Element, row: int, which: int) -> np.ndarray:
        found = np.zeros(0, dtype=np.int64)
        for k, one in enumerate(element.properties):
            count = 1
            if one.length:
                count = int(self._numbers(one.length, 1, element, row)[0])
            if count < 0:
                raise Damaged(f"byte {self.at}", f"{element.name} {row}: a list of {count} entries")
            some = self._numbers(one.kind, count, element, row)
            if k == which:
                found = some.astype(np.int64)
        return found

    def _numbers(self, kind: str, count: int, element: Element, row: int) -> np.ndarray:
        size = np.dtype(kind).itemsize * count
        if self.at + size > len(self.content):
            left = len(self.content) - self.at
            what = f"{element.name} {row} needs {size} bytes, {left} are left: the file is cut or damaged"
            raise Damaged(f"byte {self.at}", what)
        found = np.frombuffer(self.content, self.order + kind, count, self.at)
        self.at += size
        return found

    def _alike(self, element: Element) -> np.ndarray | None:
        """The triangles where all faces have as many corners as the first; None where they have not."""
        which, start = _corners(element), self.at
        if not element.count or sum(bool(one.length) for one in element.properties) != 1:
            return None
        length = len(self._row(element, 0, which))
        kinds = []
        for k, one in enumerate(element.properties):
            if one.length:
                kinds.append((f"n{k}", self.order + one.length))
            shape = (length,) if one.length else ()
            kinds.append((f"f{k}", self.order + one.kind, shape))
        kind = np.dtype(kinds)
        self.at = start
        if not length or start + kind.itemsize * element.count > len(self.content):
            return None
        table = np.frombuffer(self.content, kind, element.count, start)
        if (table[f"n{which}"] != length).any():
            return None
        self.at = start + table.nbytes
        corners = table[f"f{which}"].astype(np.int64)
        if length == 3:
            return corners
        return fans(corners.ravel(), np.full(element.count, length))


class _Text:
    """The same of a text file: a row is a line."""

    def __init__(self, content: bytes, line: int):
        self.lines = [
            (line + k, words) for k, row in enumerate(content.split(b"\n"), 1) if (words := row.split())
        ]
        self.at = 0

    def check_room(self, element: Element) -> None:
        left = len(self.lines) - self.at
        if element.properties and element.count > left:
            raise _too_few(element, element.count, left, "lines")

    def rows(self, element: Element) -> np.ndarray:
        width = len(element.properties)
        return np.array(
            [self._numbers(words, number, width) for number, words in self._next(element)], dtype=np.float64
        ).reshape(-1, width)

    def polygons(self, element: Element) -> np.ndarray:
        which, corners, lengths = _corners(element), [], []
        for number, words in self._next(element):
            at = 0
            for k, one in enumerate(element.properties):
                count = 1
                if one.length:
                    (length,) = self._numbers(words[at:], number, 1)
                    count, at = int(length) if 0 <= length <= len(words) else -1, at + 1
                if count < 0 or at + count > len(words):
                    what = f"a list of {shown(words[at - 1])} entries was expected, {len(words) - at} follow"
                    raise Damaged(f"line {number}", what)
                if k == which:
                    some = self._numbers(words[at : at + count], number, count)
                    if any(x != x or abs(x) > 2**53 or x != int(x) for x in some):
                        raise Damaged(f"line {number}", f"whole numbers were expected, found {some[:4]}")
                    corners += map(int, some)
                    lengths.append(count)
                at += count
        return fans(corners, np.array(lengths, dtype=np.int64))

    def skip(self, element: Element) -> None:
        self.at += element.count

    def _next(self, element: Element) -> list[tuple[int, list[bytes]]]:
        found = self.lines[self.at : self.at + element.count]
        self.at += element.count
        return found

    def _numbers(self, words: list[bytes], number: int, count: int) -> list[float]:
        try:
            found = [float(word) for word in words[:count]]
        except ValueError:
            found = []
        if len(found) < count:
            what = f"{count} numbers were expected, found {shown(b' '.join(words))}"
            raise Damaged(f"line {number}", what)
        return found
