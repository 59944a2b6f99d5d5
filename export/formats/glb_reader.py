"""Meshes from binary glTF 2.0, in millimetres with z upwards."""

import json
import struct
from typing import Any

import numpy as np
from jaxtyping import Float

from export.formats.glb import BINARY, JSON, MAGIC, TO_GLTF
from export.formats.scene import moved
from ifs.mesh import Mesh

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
CHANNELS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TRIANGLES, STRIP, FAN = 4, 5, 6
DEEPEST = 64
PLAIN = {"KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"}


def read_glb(content: bytes) -> Mesh:
    """The triangles of the scene of a file, each body at its places, as one mesh.

    Lengths are metres there and y is upwards; they become millimetres, and z is upwards. Primitives that
    share their positions share the vertices. `ValueError`, `KeyError`, `IndexError` or `struct.error` for
    what is no such file, and for compressed meshes.
    """
    document, numbers = _chunks(content)
    unknown = set(document.get("extensionsRequired", [])) - PLAIN
    if unknown:
        raise ValueError(f"the extension {min(unknown)} is not read here")
    back = np.linalg.inv(TO_GLTF)
    scenes = document.get("scenes") or [{"nodes": range(len(document.get("nodes", [])))}]
    points, faces, first = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    stack = [(node, back, 0) for node in reversed(list(scenes[document.get("scene", 0)].get("nodes", [])))]
    while stack:
        number, above, depth = stack.pop()
        if depth > DEEPEST:
            raise ValueError(f"nodes within nodes more than {DEEPEST} deep")
        node = document["nodes"][number]
        transform = _snapped(above @ _matrix(node))
        if "mesh" in node:
            for mesh in (moved(own, transform) for own in _meshes(document, numbers, node["mesh"])):
                points.append(mesh.vertices)
                faces.append(mesh.faces + first)
                first += len(mesh.vertices)
        stack += [(child, transform, depth + 1) for child in reversed(node.get("children", []))]
    return Mesh(np.concatenate(points), np.concatenate(faces))


def _snapped(transform: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "4 4"]:
    """The transform with what rounding left of whole numbers taken away."""
    near = np.round(transform)
    return np.where(np.abs(transform - near) < 1e-13, near, transform)


def _chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    magic, edition, size = struct.unpack_from("<4sII", content)
    if magic != MAGIC or edition != 2 or size > len(content):
        raise ValueError(f"this is no binary glTF 2 file, or it is cut after {len(content)} bytes")
    at, found = 12, {JSON: b"", BINARY: b""}
    while at + 8 <= size:
        length, kind = struct.unpack_from("<I4s", content, at)
        if at + 8 + length > size:
            raise ValueError("a chunk that ends behind the file")
        if kind in found and not found[kind]:
            found[kind] = content[at + 8 : at + 8 + length]
        at += 8 + length
    return json.loads(found[JSON]), found[BINARY]


def _matrix(node: dict[str, Any]) -> Float[np.ndarray, "4 4"]:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1]), dtype=np.float64).tolist()
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    found = np.eye(4)
    found[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]), dtype=np.float64)
    found[:3, 3] = node.get("translation", [0, 0, 0])
    return found


def _meshes(document: dict[str, Any], numbers: bytes, mesh: int) -> list[Mesh]:
    """One mesh for each set of positions that primitives share."""
    found: dict[int, list[np.ndarray]] = {}
    for primitive in document["meshes"][mesh]["primitives"]:
        mode, position = primitive.get("mode", TRIANGLES), primitive["attributes"]["POSITION"]
        if mode not in (TRIANGLES, STRIP, FAN):
            continue
        if "indices" in primitive:
            corners = _numbers(document, numbers, primitive["indices"]).ravel().astype(np.int64)
        else:
            corners = np.arange(document["accessors"][position]["count"])
        found.setdefault(position, []).append(_triangles(corners, mode))
    return [
        Mesh(_numbers(document, numbers, position).astype(np.float64), np.concatenate(faces))
        for position, faces in found.items()
    ]


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        return np.column_stack([np.broadcast_to(corners[:1], len(corners) - 2), corners[1:-1], corners[2:]])
    strip = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _numbers(document: dict[str, Any], numbers: bytes, accessor: int) -> np.ndarray:
    """The rows of an accessor. Integers that stand for shares are divided by the largest."""
    told = document["accessors"][accessor]
    if "sparse" in told or "bufferView" not in told:
        raise ValueError(f"accessor {accessor} is sparse, which is not read here")
    view = document["bufferViews"][told["bufferView"]]
    if view.get("buffer", 0) != 0 or "uri" in document["buffers"][0]:
        raise ValueError("numbers in other files")
    kind = np.dtype(COMPONENTS[told["componentType"]])
    width, count = CHANNELS[told["type"]], told["count"]
    begin = view.get("byteOffset", 0) + told.get("byteOffset", 0)
    step = view.get("byteStride", width * kind.itemsize)
    if min(begin, count, step) < 0 or (
        count and begin + step * (count - 1) + width * kind.itemsize > len(numbers)
    ):
        raise ValueError(f"accessor {accessor} ends behind the numbers")
    found = np.ndarray((count, width), kind, numbers, begin, (step, kind.itemsize))
    if told.get("normalized"):
        return np.maximum(found / np.iinfo(kind).max, -1.0)
    return found
