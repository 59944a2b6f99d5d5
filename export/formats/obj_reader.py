"""Meshes from OBJ and OFF files: text."""

import re

import numpy as np

from export.formats.damage import Damaged, fans, shown
from ifs.mesh import Mesh

LARGEST = 2**62
MOST_ODD = 1 << 16  # numbers that Python reads, for they are long or no plain decimals


def read_obj(content: bytes) -> Mesh:
    """The faces of an OBJ file, all objects together, as triangles; normals and textures are passed over.

    Faces may count vertices from the last one backwards. Raises `Damaged`.
    """
    if b"\0" in content[:10_000]:
        raise Damaged(f"byte {content.index(0)}", "a byte 0, which no text has: this is no OBJ file")
    found = None if b"\\" in content else _read_plain(content)
    if found is None:
        text = content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
        return _read_lines(text.split(b"\n"))
    return found


def _read_plain(content: bytes) -> Mesh | None:
    """The same at once; None where something is wrong, or needs a closer look."""
    from export.formats.obj_kernels import counts, fill

    text = np.frombuffer(content, dtype=np.uint8)
    vertices, faces, used = counts(text)
    points, corners = np.empty((vertices, 3)), np.empty(used, dtype=np.int64)
    lengths, odd = np.empty(faces, dtype=np.int64), np.empty((MOST_ODD, 3), dtype=np.int64)
    left = fill(text, points, corners, lengths, odd)
    if left < 0 or not used or corners.max() >= vertices:
        return None
    try:
        for place, start, end in odd[:left].tolist():
            points.flat[place] = float(content[start:end])
    except ValueError:
        return None
    if used == 3 * faces and (lengths == 3).all():
        return Mesh(points, corners.reshape(-1, 3))
    return Mesh(points, fans(corners, lengths))


def _read_lines(lines: list[bytes]) -> Mesh:
    """The same line by line, with the place of what is wrong."""
    points: list[tuple[float, float, float]] = []
    corners: list[int] = []
    lengths: list[int] = []
    named: list[tuple[int, int]] = []  # the largest vertex so far, and the line that names it
    for number, line in enumerate(lines, 1):
        words = line.split(b"#")[0].split()
        if not words:
            continue
        if words[0] == b"v":
            try:
                x, y, z = (float(word) for word in words[1:4])
            except ValueError:
                what = f"three numbers were expected after v, found {shown(line.strip())}"
                raise Damaged(f"line {number}", what) from None
            points.append((x, y, z))
        elif words[0] == b"f":
            face = [_vertex(word, len(points), number, line) for word in words[1:]]
            if len(face) < 3:
                what = f"three vertices or more were expected after f, found {shown(line.strip())}"
                raise Damaged(f"line {number}", what)
            if not named or max(face) > named[-1][0]:
                named.append((max(face), number))
            corners += face
            lengths.append(len(face))
    for vertex, number in named:
        if vertex >= len(points):
            raise Damaged(f"line {number}", f"vertex {vertex + 1} is named, the file has {len(points)}")
    if not lengths:
        raise Damaged(f"after line {len(lines)}", "no face was found: lines such as 'f 1 2 3' were expected")
    return Mesh(np.array(points, dtype=np.float64).reshape(-1, 3), fans(corners, np.array(lengths)))


def _vertex(word: bytes, known: int, number: int, line: bytes) -> int:
    try:
        vertex = int(word.split(b"/")[0][:25])
    except ValueError:
        vertex = 0
    vertex = vertex - 1 if vertex > 0 else known + vertex if vertex < 0 else -1
    if not 0 <= vertex < LARGEST:
        what = f"{shown(word)} names no vertex ({known} come before) in {shown(line.strip())}"
        raise Damaged(f"line {number}", what)
    return vertex


def read_off(content: bytes) -> Mesh:
    """The faces of an OFF file (also COFF, NOFF, CNOFF) as triangles. Raises `Damaged`."""
    rows = [
        (number, words)
        for number, line in enumerate(content.split(b"\n"), 1)
        if (words := line.split(b"#")[0].split())
    ]
    if not rows or not re.fullmatch(rb"(ST)?C?N?OFF", rows[0][1][0]):
        found = shown(rows[0][1][0]) if rows else "nothing"
        raise Damaged(f"line {rows[0][0] if rows else 1}", f"'OFF' was expected, found {found}")
    rows[0] = (rows[0][0], rows[0][1][1:])
    rows = rows[not rows[0][1] :]
    if not rows:
        raise Damaged("after line 1", "the numbers of vertices and faces were expected, the file ends")
    counts = _numbers(rows[0], 2, int, "the numbers of vertices, faces and edges")
    if min(counts) < 0 or sum(counts) > len(rows) - 1:
        what = f"{counts[0]} vertices and {counts[1]} faces are announced, {len(rows) - 1} lines follow"
        raise Damaged(f"line {rows[0][0]}", what)
    body, faces = rows[1 : 1 + counts[0]], rows[1 + counts[0] : 1 + sum(counts)]
    points = [_numbers(row, 3, float, "the three coordinates of a vertex") for row in body]
    corners: list[int] = []
    lengths: list[int] = []
    for row in faces:
        (length,) = _numbers(row, 1, int, "the number of corners of a face")
        if not 0 <= length < len(row[1]):
            what = f"{length} corners are announced, {len(row[1]) - 1} numbers follow"
            raise Damaged(f"line {row[0]}", what)
        face = _numbers((row[0], row[1][1:]), length, int, "the corners of a face")
        if face and (min(face) < 0 or max(face) >= counts[0]):
            raise Damaged(f"line {row[0]}", f"vertices {min(face)} to {max(face)} of {counts[0]} are named")
        corners += face
        lengths.append(length)
    return Mesh(np.array(points, dtype=np.float64).reshape(-1, 3), fans(corners, np.array(lengths, int)))


def _numbers(row: tuple[int, list[bytes]], count: int, kind: type, meant: str) -> list:
    try:
        found = [kind(word[:40]) for word in row[1][:count]]
    except ValueError:
        found = []
    if len(found) < count:
        raise Damaged(f"line {row[0]}", f"{meant} were expected, found {shown(b' '.join(row[1]))}")
    return found
