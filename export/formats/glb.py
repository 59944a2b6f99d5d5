"""Binary glTF 2.0: metres with y upwards in the file, millimetres with z upwards in its meshes."""

import json
import os
import struct
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from export.formats.atomic import whole_file
from export.formats.scene import Scene, WrongScene, check_scene, scene_of, triangle_colours, triangles
from ifs.mesh import Mesh

MAGIC, JSON, BINARY = b"glTF", b"JSON", b"BIN\0"
FLOAT, UNSIGNED = 5126, 5125
VERTICES, INDICES = 34962, 34963
# (x, y, z) in mm becomes (x, z, -y) in m; the matrix is written column by column.
TO_GLTF = np.array([[0.001, 0, 0, 0], [0, 0, 0.001, 0], [0, -0.001, 0, 0], [0, 0, 0, 1]])
MOST_COLOURS = 4096
MOST_BYTES = 2**32 - 1


def write_glb(
    shape: Mesh | Scene,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write a mesh or a scene (mm) as binary glTF, in single precision.

    A node above all turns millimetres into metres and z upwards into y upwards, as glTF has it. A body of
    several places is written once. The faces of one colour are one primitive; all primitives of a body share
    its vertices, so that it stays closed. The recipe stands in `asset.extras`. The same arguments give the
    same bytes. The file appears whole or not at all. Raises `WrongMesh`, and `WrongScene` above 4096 colours
    a body and above 4 GiB.

    >>> import pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "one.glb"
    >>> write_glb(Mesh(np.eye(3), np.array([[0, 1, 2]])), place)
    >>> place.read_bytes()[:4]
    b'glTF'
    """
    scene = scene_of(shape, title)
    check_scene(scene)
    parts: list[np.ndarray] = []
    told = _document(scene, recipe or {}, title, parts)
    text = json.dumps(told, sort_keys=True, separators=(",", ":"), ensure_ascii=True).encode()
    text += b" " * (-len(text) % 4)
    size = sum(part.nbytes for part in parts)
    whole = 28 + len(text) + size
    if whole > MOST_BYTES:
        raise WrongScene(f"{whole} bytes: a GLB file can have {MOST_BYTES}; write .3mf or .ply")
    with whole_file(path) as file:
        file.write(MAGIC + struct.pack("<II", 2, whole) + struct.pack("<I", len(text)) + JSON + text)
        file.write(struct.pack("<I", size) + BINARY)
        for part in parts:
            file.write(part.data)


def _document(scene: Scene, recipe: Mapping[str, str], title: str, parts: list[np.ndarray]) -> dict[str, Any]:
    """What the file says of its numbers; these are appended to `parts`."""
    told: dict[str, Any] = {
        "asset": {
            "version": "2.0",
            "generator": f"bcifs {version('bcifs')}",
            "extras": {key: recipe[key] for key in sorted(recipe)},
        },
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "accessors": [],
        "bufferViews": [],
        "meshes": [],
        "materials": [],
    }
    for body in scene.bodies:
        points = np.ascontiguousarray(body.mesh.points_3d() + 0.0, dtype="<f4")
        position = _accessor(told, parts, points, FLOAT, "VEC3", VERTICES)
        rgba, which = triangle_colours(body)
        if len(rgba) > MOST_COLOURS:
            raise WrongScene(f"{len(rgba)} colours of one body: a GLB file can have {MOST_COLOURS} here")
        corners = triangles(body.mesh).astype("<u4")
        primitives = []
        for colour in range(max(len(rgba), 1)):
            some = np.ascontiguousarray(corners[which == colour]) if len(rgba) > 1 else corners
            indices = _accessor(told, parts, some.reshape(-1), UNSIGNED, "SCALAR", INDICES)
            primitive: dict[str, Any] = {"attributes": {"POSITION": position}, "indices": indices}
            if len(rgba):
                primitive["material"] = _material(told["materials"], rgba[colour])
            primitives.append(primitive)
        told["meshes"].append({"primitives": primitives} | ({"name": body.name} if body.name else {}))
    nodes: list[dict[str, Any]] = [{"matrix": TO_GLTF.T.ravel().tolist()}]
    nodes[0]["children"] = list(range(1, len(scene.stands) + 1))
    if title:
        nodes[0]["name"] = title
    for place in scene.stands:
        node: dict[str, Any] = {"mesh": place.body}
        if (place.transform != np.eye(4)).any():
            node["matrix"] = (place.transform + 0.0).T.ravel().tolist()
        if scene.bodies[place.body].name:
            node["name"] = scene.bodies[place.body].name
        nodes.append(node)
    told["nodes"] = nodes
    told["buffers"] = [{"byteLength": sum(part.nbytes for part in parts)}]
    return {key: value for key, value in told.items() if value != []}


def _accessor(
    told: dict[str, Any], parts: list[np.ndarray], array: np.ndarray, component: int, kind: str, target: int
) -> int:
    begin = sum(part.nbytes for part in parts)
    view = {"buffer": 0, "byteOffset": begin, "byteLength": array.nbytes, "target": target}
    told["bufferViews"].append(view)
    accessor: dict[str, Any] = {"bufferView": len(told["bufferViews"]) - 1, "componentType": component}
    accessor |= {"type": kind, "count": len(array)}
    if kind == "VEC3":
        accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
    told["accessors"].append(accessor)
    parts.append(array)
    return len(told["accessors"]) - 1


def _material(materials: list[dict[str, Any]], rgba: np.ndarray) -> int:
    """The number of a material of this colour: glTF has red, green and blue in proportion to light."""
    shares = rgba / 255
    light = np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)
    factors = [*light[:3].round(6).tolist(), round(float(shares[3]), 6)]
    found: dict[str, Any] = {
        "pbrMetallicRoughness": {"baseColorFactor": factors, "metallicFactor": 0, "roughnessFactor": 0.9}
    }
    if rgba[3] < 255:
        found["alphaMode"] = "BLEND"
    if found not in materials:
        materials.append(found)
    return materials.index(found)
