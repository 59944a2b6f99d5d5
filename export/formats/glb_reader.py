"""Meshes from binary glTF 2.0, in millimetres with z upwards."""

import json
import struct
from typing import Any

import numpy as np
from jaxtyping import Float

from export.formats.damage import Damaged, shown
from export.formats.glb import BINARY, JSON, MAGIC, TO_GLTF
from export.formats.scene import moved
from ifs.mesh import Mesh

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
CHANNELS = {"SCALAR": 1, "VEC3": 3}
TRIANGLES, STRIP, FAN = 4, 5, 6
DEEPEST, MOST_NODES, MOST = 64, 100_000, 1 << 28
LARGEST = 1e100
HEAD = "the JSON chunk"
PLAINLY = "save it as plain glTF 2.0, without compression"
PLAIN = {"KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"}


def read_glb(content: bytes) -> Mesh:
    """The triangles of the scene of a file, each body at its places, as one mesh.

    Lengths are metres there and y is upwards; they become millimetres, and z is upwards. Primitives that
    share their positions share the vertices. Raises `Damaged` for what is no such file, and for compressed
    meshes.
    """
    document, numbers = _chunks(content)
    try:
        return _scene(document, numbers)
    except Damaged:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        reason = f"{type(error).__name__} {error}"[:80]
        raise Damaged(HEAD, f"it does not fit the glTF 2.0 format ({reason})") from None


def _scene(document: dict[str, Any], numbers: bytes) -> Mesh:
    unknown = set(document.get("extensionsRequired", [])) - PLAIN
    if unknown:
        raise Damaged(HEAD, f"the extension {shown(str(min(unknown)))} is not read here", PLAINLY)
    back = np.linalg.inv(TO_GLTF)
    scenes = document.get("scenes") or [{"nodes": range(len(document.get("nodes", [])))}]
    points, faces, first, count, visited = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0, 0, 0
    scene = _entry(scenes, document.get("scene", 0), "scenes")
    stack = [(node, back, 0) for node in reversed(list(scene.get("nodes", [])))]
    while stack:
        number, above, depth = stack.pop()
        visited += 1
        if depth > DEEPEST or visited > MOST_NODES:
            raise Damaged(HEAD, f"nodes within nodes without end, more than {DEEPEST} deep or too many")
        node = _entry(document.get("nodes", []), number, "nodes")
        transform = _snapped(above @ _matrix(node, number))
        if "mesh" in node:
            for mesh in (moved(own, transform) for own in _meshes(document, numbers, node["mesh"])):
                points.append(mesh.vertices)
                faces.append(mesh.faces + first)
                first, count = first + len(mesh.vertices), count + len(mesh.faces)
                if max(first, count) > MOST:
                    raise Damaged(HEAD, f"more than {MOST} triangles with all places of all meshes")
        stack += [(child, transform, depth + 1) for child in reversed(node.get("children", []))]
    return Mesh(np.concatenate(points), np.concatenate(faces))


def _entry(rows: Any, number: Any, name: str) -> Any:
    """An entry of one of the lists of the document."""
    if not isinstance(rows, (list, range)) or isinstance(number, bool) or not isinstance(number, int):
        raise Damaged(HEAD, f"an entry of the list {name} was expected, found {shown(str(number))}")
    if not 0 <= number < len(rows):
        raise Damaged(HEAD, f"entry {number} of {name} is named, there are {len(rows)}")
    return rows[number]


def _snapped(transform: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "4 4"]:
    """The transform with what rounding left of whole numbers taken away."""
    near = np.round(transform)
    return np.where(np.abs(transform - near) < 1e-13, near, transform)


def _chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    if content[:4] != MAGIC:
        raise Damaged("byte 0", f"'glTF' was expected, found {shown(content[:4])}")
    if len(content) < 20:
        raise Damaged(f"after {len(content)} bytes", "the file ends within its head of 20 bytes")
    edition, size = struct.unpack_from("<II", content, 4)
    if edition != 2:
        raise Damaged("byte 4", f"version 2 of glTF was expected, found {edition}", PLAINLY)
    if size > len(content):
        what = f"{size} bytes are announced, the file has {len(content)}: it is cut"
        raise Damaged("byte 8", what)
    at, found = 12, {JSON: b"", BINARY: b""}
    while at + 8 <= size:
        length, kind = struct.unpack_from("<I4s", content, at)
        if at + 8 + length > size:
            what = f"a chunk of {length} bytes is announced, {size - at - 8} are left"
            raise Damaged(f"byte {at}", what)
        if kind in found and not found[kind]:
            found[kind] = content[at + 8 : at + 8 + length]
        at += 8 + length
    try:
        document = json.loads(found[JSON])
    except json.JSONDecodeError as error:
        raise Damaged(f"{HEAD}, character {error.pos}", f"JSON was expected: {error.msg}") from None
    except UnicodeDecodeError as error:
        raise Damaged(f"{HEAD}, byte {error.start}", "UTF-8 was expected") from None
    except (RecursionError, ValueError):
        raise Damaged(HEAD, "lists within lists without end, or a number of too many digits") from None
    if not isinstance(document, dict):
        raise Damaged(HEAD, "a JSON object was expected")
    return document, found[BINARY]


def _matrix(node: dict[str, Any], number: int) -> Float[np.ndarray, "4 4"]:
    if "matrix" in node:
        return _finite(node["matrix"], 16, number).reshape(4, 4).T
    x, y, z, w = _finite(node.get("rotation", [0, 0, 0, 1]), 4, number).tolist()
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    found = np.eye(4)
    found[:3, :3] = turn * _finite(node.get("scale", [1, 1, 1]), 3, number)
    found[:3, 3] = _finite(node.get("translation", [0, 0, 0]), 3, number)
    return found


def _finite(values: Any, count: int, node: int) -> np.ndarray:
    found = np.array(values, dtype=np.float64)
    if found.shape != (count,) or not (np.abs(found) < LARGEST).all():
        what = f"{count} numbers below {LARGEST:g} were expected for the place of node {node}"
        raise Damaged(HEAD, f"{what}, found {shown(str(values))}")
    return found


def _meshes(document: dict[str, Any], numbers: bytes, mesh: int) -> list[Mesh]:
    """One mesh for each set of positions that primitives share."""
    found: dict[int, list[np.ndarray]] = {}
    for primitive in _entry(document.get("meshes", []), mesh, "meshes")["primitives"]:
        mode, position = primitive.get("mode", TRIANGLES), primitive["attributes"]["POSITION"]
        if mode not in (TRIANGLES, STRIP, FAN):
            continue
        if "indices" in primitive:
            corners = _numbers(document, numbers, primitive["indices"], ("SCALAR",)).ravel()
            if corners.dtype.kind not in "iu":
                raise Damaged(HEAD, f"accessor {primitive['indices']} of indices has no whole numbers")
            corners = corners.astype(np.int64)
        else:
            corners = np.arange(len(_numbers(document, numbers, position, ("VEC3",))))
        found.setdefault(position, []).append(_triangles(corners, mode))
    meshes = []
    for position, faces in found.items():
        points, corners = _numbers(document, numbers, position, ("VEC3",)), np.concatenate(faces)
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            what = f"indices of mesh {mesh} reach {corners.max()}, accessor {position} has {len(points)} rows"
            raise Damaged(HEAD, what)
        meshes.append(Mesh(points.astype(np.float64), corners))
    return meshes


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == FAN:
        return np.column_stack([np.broadcast_to(corners[:1], len(corners) - 2), corners[1:-1], corners[2:]])
    strip = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _numbers(document: dict[str, Any], numbers: bytes, accessor: int, kinds: tuple[str, ...]) -> np.ndarray:
    """The rows of an accessor. Integers that stand for shares are divided by the largest."""
    told = _entry(document.get("accessors", []), accessor, "accessors")
    if "sparse" in told or "bufferView" not in told:
        raise Damaged(HEAD, f"accessor {accessor} is sparse or empty, which is not read here", PLAINLY)
    view = _entry(document.get("bufferViews", []), told["bufferView"], "bufferViews")
    if view.get("buffer", 0) != 0 or "uri" in _entry(document.get("buffers", []), 0, "buffers"):
        raise Damaged(HEAD, "the numbers stand in other files", "save it as one file (.glb)")
    if told.get("componentType") not in COMPONENTS or told.get("type") not in kinds:
        what = f"a component type of {sorted(COMPONENTS)} and type {' or '.join(kinds)} were expected"
        raise Damaged(HEAD, f"{what} of accessor {accessor}")
    kind = np.dtype(COMPONENTS[told["componentType"]])
    width = CHANNELS[told["type"]]
    count, begin = _count(told, "count", 0), _count(view, "byteOffset", 0) + _count(told, "byteOffset", 0)
    step = _count(view, "byteStride", width * kind.itemsize)
    if step < width * kind.itemsize:
        raise Damaged(HEAD, f"rows of accessor {accessor} lie {step} bytes apart: they overlap")
    if count and begin + step * (count - 1) + width * kind.itemsize > len(numbers):
        what = f"{count} rows of accessor {accessor} are announced from byte {begin} on"
        raise Damaged(HEAD, f"{what}, {len(numbers)} bytes are there")
    found = np.ndarray((count, width), kind, numbers, begin if count else 0, (step, kind.itemsize))
    if told.get("normalized") and kind.kind in "iu":
        return np.maximum(found / np.iinfo(kind).max, -1.0)
    return found


def _count(told: dict[str, Any], key: str, otherwise: int) -> int:
    found = told.get(key, otherwise)
    if isinstance(found, bool) or not isinstance(found, int) or not 0 <= found < 2**48:
        raise Damaged(HEAD, f"a whole number {key} of 0 or more was expected, found {shown(str(found))}")
    return found
