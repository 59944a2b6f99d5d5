"""The 3MF format: millimetres, bodies and their places, colours, the recipe in its metadata."""

import os
import re
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from jaxtyping import Float

from export.formats.archive import zip_archive
from export.formats.atomic import whole_file
from export.formats.scene import (
    Body,
    Place,
    Scene,
    check_scene,
    mirrors,
    moved,
    scene_of,
    triangle_colours,
    triangles,
)
from export.formats.text import length_rows, number_rows
from ifs.mesh import Mesh

NAMESPACE = "urn:bcifs:recipe:1"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
UNWRITABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
VERTEX = ('<vertex x="', '" y="', '" z="', '"/>\n')
TRIANGLE = ('<triangle v1="', '" v2="', '" v3="', '"/>\n')
PER_FACE, LARGE = 150, 1 << 32  # bytes that a face and its vertices take at most

CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">\
<Default Extension="rels" \
ContentType="application/vnd.openxmlformats-package.relationships+xml"/>\
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>\
</Types>
"""
RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">\
<Relationship Id="model" Target="/3D/3dmodel.model" \
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"""


def write_3mf(
    shape: Mesh | Scene,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write a mesh or a scene (mm) as a 3MF file, with how it was made.

    Each entry of `recipe` becomes the metadata `bcifs:KEY` (namespace `urn:bcifs:recipe:1`), `title` the
    title, and the application is named with its version; line ends become line feeds. Positions are
    rounded to a nanometre. Colours are a colour group (materials extension), one for each body that has
    colours. A body of several places is written once, and its places are components with transforms; a
    mirrored one is written again. The same arguments give the same bytes. The file appears whole or not at
    all. `ValueError` for a recipe key that is no XML name or text that XML cannot hold, `WrongMesh`.

    >>> import numpy as np, pathlib, tempfile, zipfile
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "corner.3mf"
    >>> write_3mf(Mesh(corners, faces), place, {"depth": "3"}, "Corner")
    >>> b'unit="millimeter"' in zipfile.ZipFile(place).read("3D/3dmodel.model")
    True
    """
    scene = scene_of(shape)
    check_scene(scene)
    metadata = _metadata(recipe or {}, title)
    for body in scene.bodies:
        _check_text("a name", body.name)
    scene = _unmirrored(scene)
    faces = sum(len(body.mesh.faces) * (body.mesh.faces.shape[1] - 2) for body in scene.bodies)
    vertices = sum(len(body.mesh.vertices) for body in scene.bodies)
    large = (faces + vertices) * PER_FACE + len(metadata) >= LARGE
    with whole_file(path) as file, zip_archive(file) as add:
        add("[Content_Types].xml", [CONTENT_TYPES.encode()])
        add("_rels/.rels", [RELATIONS.encode()])
        add("3D/3dmodel.model", _model(scene, metadata), large=large)


def _metadata(recipe: Mapping[str, str], title: str) -> str:
    rows = [("Title", title)] if title else []
    rows.append(("Application", f"bcifs {version('bcifs')}"))
    for key in sorted(recipe):
        if not KEY.fullmatch(key):
            raise ValueError(f"recipe key {key!r}: letters, digits, '_', '-' and '.' only")
        rows.append((f"bcifs:{key}", recipe[key]))
    lines = []
    for name, text in rows:
        _check_text(name, text)
        lines.append(f'<metadata name="{name}">{escape(_lines(text))}</metadata>\n')
    return "".join(lines)


def _check_text(name: str, text: str) -> None:
    wrong = UNWRITABLE.search(text)
    if wrong:
        raise ValueError(f"{name}: XML cannot hold the character {wrong.group()!r}")


def _lines(text: str) -> str:
    """Line ends as XML has them: readers turn the others into these anyway."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _unmirrored(scene: Scene) -> Scene:
    """The scene with a body of its own wherever a body is mirrored: 3MF mirrors no meshes."""
    bodies, places = list(scene.bodies), []
    for place in scene.stands:
        if not mirrors(place.transform):
            places.append(place)
            continue
        body = scene.bodies[place.body]
        places.append(Place(len(bodies)))
        bodies.append(Body(moved(body.mesh, place.transform), body.name, body.colours))
    used = sorted({place.body for place in places})
    return Scene(
        tuple(bodies[body] for body in used),
        tuple(Place(used.index(place.body), place.transform) for place in places),
        scene.together,
    )


def _model(scene: Scene, metadata: str) -> Iterator[bytes]:
    """The model part, piece by piece."""
    colours = f' xmlns:m="{MATERIALS}"' if any(len(body.rgba()) for body in scene.bodies) else ""
    yield (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en-US" '
        f'xmlns="{CORE}" xmlns:bcifs="{NAMESPACE}"{colours}>\n{metadata}<resources>'
    ).encode()
    first = 1 + sum(len(body.rgba()) > 0 for body in scene.bodies)
    group = 0
    for number, body in enumerate(scene.bodies):
        if len(body.rgba()):
            group += 1
            yield from _object(body, number + first, group)
        else:
            yield from _object(body, number + first, 0)
    items = [(place.body + first, _transform(place.transform)) for place in scene.stands]
    if scene.together and len(items) > 1:
        whole = first + len(scene.bodies)
        yield f'<object id="{whole}" type="model"><components>\n'.encode()
        for body, transform in items:
            yield f'<component objectid="{body}"{transform}/>\n'.encode()
        yield b"</components></object>\n"
        items = [(whole, "")]
    yield b"</resources>\n<build>"
    for body, transform in items:
        yield f'<item objectid="{body}"{transform}/>'.encode()
    yield b"</build></model>\n"


def _object(body: Body, number: int, group: int) -> Iterator[bytes]:
    name = f" name={quoteattr(_lines(body.name))}" if body.name else ""
    rgba, which = triangle_colours(body)
    if group:
        colours = "".join(f'<m:color color="#{bytes(row).hex().upper()}"/>\n' for row in rgba)
        yield f'<m:colorgroup id="{group}">\n{colours}</m:colorgroup>\n'.encode()
        name += f' pid="{group}" pindex="0"'
    yield f'<object id="{number}" type="model"{name}><mesh><vertices>\n'.encode()
    yield from _rows(VERTEX, body.mesh.points_3d())
    yield b"</vertices><triangles>\n"
    corners = triangles(body.mesh)
    if len(rgba) > 1:
        words = (*TRIANGLE[:3], f'" pid="{group}" p1="', TRIANGLE[3])
        yield from _rows(words, np.column_stack([corners, which]))
    else:
        yield from _rows(TRIANGLE, corners)
    yield b"</triangles></mesh></object>\n"


def _rows(words: tuple[str, ...], table: np.ndarray) -> Iterator[bytes]:
    return length_rows(words, table) if table.dtype.kind == "f" else number_rows(words, table)


def _transform(transform: Float[np.ndarray, "4 4"]) -> str:
    """The attribute: 3MF has points as rows, so the transposed matrix, without its last column."""
    if (transform == np.eye(4)).all():
        return ""
    return f' transform="{" ".join(f"{x:.15g}" for x in (transform[:3].T + 0.0).ravel().tolist())}"'
