"""Meshes from STL files, binary and text."""

import re

import numpy as np

from export.formats.damage import Damaged, shown
from ifs.mesh import Mesh

HEAD, ROW = 84, 50
CORNERS = re.compile(rb"^[ \t]*vertex[ \t]+([^\r\n]*)", re.MULTILINE | re.IGNORECASE)
BEGINS = re.compile(rb"^[ \t]*facet\b", re.MULTILINE | re.IGNORECASE)
ENDS = re.compile(rb"^[ \t]*endfacet\b", re.MULTILINE | re.IGNORECASE)
SOLID_ENDS = re.compile(rb"^[ \t]*endsolid\b", re.MULTILINE | re.IGNORECASE)
ORDER = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")
ROWS = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])


def read_stl(content: bytes) -> Mesh:
    """The triangles of an STL file, each with three vertices of its own. Raises `Damaged`.

    A file is binary where its length fits the number of triangles it announces, else text where it begins
    with "solid".
    """
    announced = int.from_bytes(content[80:HEAD], "little") if len(content) >= HEAD else -1
    if announced >= 0 and len(content) == HEAD + ROW * announced:
        rows = np.frombuffer(content, dtype=ROWS, offset=HEAD)
        points = rows["corners"].reshape(-1, 3).astype(np.float64)
    elif content.lstrip()[:5].lower() == b"solid" and b"\0" not in content[:HEAD]:
        points = _text(content)
    elif announced < 0:
        raise Damaged(
            f"after {len(content)} bytes", "the file ends; a binary STL file has a head of 84 bytes, a "
            'text one begins with "solid"',
        )  # fmt: skip
    else:
        raise Damaged(
            "byte 80",
            f"{announced} triangles are announced, for which {HEAD + ROW * announced} bytes are expected, "
            f"but the file has {len(content)}: it is cut, the number is wrong, or it is no STL file",
        )
    return Mesh(points, np.arange(len(points)).reshape(-1, 3))


def _text(content: bytes) -> np.ndarray:
    corners = CORNERS.findall(content)
    facets = len(BEGINS.findall(content))
    if len(ENDS.findall(content)) == facets and len(corners) == 3 * facets and SOLID_ENDS.search(content):
        words = b"\n".join(corners).split()
        if len(words) == 9 * facets:
            try:
                return np.array(words, dtype=np.float64).reshape(-1, 3)
            except ValueError:
                pass
    return _line_by_line(content)


def _line_by_line(content: bytes) -> np.ndarray:
    """The same, with the place of what is wrong."""
    points, state, number = [], 0, 0
    ended = False
    for number, line in enumerate(content.splitlines(), 1):
        words = line.split()
        if not words:
            continue
        word = words[0].decode("latin-1").lower()
        if state == 0 and word in ("solid", "endsolid"):
            ended = word == "endsolid"
            continue
        if word != ORDER[state]:
            what = f'"{ORDER[state]}" was expected, found {shown(line.strip())}'
            raise Damaged(f"line {number}", what + (' (or "endsolid")' if state == 0 else ""))
        if word == "vertex":
            try:
                x, y, z = (float(word) for word in words[1:])
            except ValueError:
                what = f"three numbers were expected after vertex, found {shown(line.strip())}"
                raise Damaged(f"line {number}", what) from None
            points.append((x, y, z))
        state = (state + 1) % len(ORDER)
    if state or not ended:
        what = f'the file ends before "{ORDER[state] if state else "endsolid"}": it is cut'
        raise Damaged(f"after line {number}", what)
    return np.array(points, dtype=np.float64).reshape(-1, 3)
