"""The 3MF format: millimetres, one object, the recipe in its metadata."""

import os
import re
import zipfile
from collections.abc import Iterator, Mapping
from xml.sax.saxutils import escape

import numpy as np

from export.atomic import whole_file
from ifs.mesh import Mesh

NAMESPACE = "urn:bcifs:recipe:1"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
UNWRITABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
ROWS = 20_000  # rows turned into text at a time
EPOCH = (1980, 1, 1, 0, 0, 0)  # every entry bears the first date a zip file can

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
    mesh: Mesh,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write a triangle mesh (mm) as a 3MF file, with how it was made.

    Each entry of `recipe` becomes the metadata `bcifs:KEY` (namespace `urn:bcifs:recipe:1`),
    `title` the title; line ends become line feeds. Positions have six decimals (a nanometre). The
    same arguments give the same bytes with the same zlib; the XML within is the same everywhere.
    The file appears whole or not at all. `ValueError` for a recipe key that is no XML name or text
    that XML cannot hold.

    >>> import numpy as np, pathlib, tempfile, zipfile
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "corner.3mf"
    >>> write_3mf(Mesh(corners, faces), place, {"depth": "3"}, "Corner")
    >>> b'unit="millimeter"' in zipfile.ZipFile(place).read("3D/3dmodel.model")
    True
    """
    metadata = _metadata(recipe or {}, title)
    with (
        whole_file(path) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive,
    ):
        for name, text in (("[Content_Types].xml", CONTENT_TYPES), ("_rels/.rels", RELATIONS)):
            archive.writestr(_entry(name), text)
        with archive.open(_entry("3D/3dmodel.model"), "w", force_zip64=False) as model:
            for piece in _model(mesh, metadata):
                model.write(piece.encode())


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, EPOCH)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.create_system = 3
    entry.external_attr = 0o644 << 16
    return entry


def _metadata(recipe: Mapping[str, str], title: str) -> str:
    rows = [("Title", title)] if title else []
    rows.append(("Application", "bcifs"))
    for key in sorted(recipe):
        if not KEY.fullmatch(key):
            raise ValueError(f"recipe key {key!r}: letters, digits, '_', '-' and '.' only")
        rows.append((f"bcifs:{key}", recipe[key]))
    lines = []
    for name, text in rows:
        wrong = UNWRITABLE.search(text)
        if wrong:
            raise ValueError(f"{name}: XML cannot hold the character {wrong.group()!r}")
        lines.append(f'<metadata name="{name}">{escape(_lines(text))}</metadata>\n')
    return "".join(lines)


def _lines(text: str) -> str:
    """Line ends as XML has them: readers turn the others into these anyway."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _model(mesh: Mesh, metadata: str) -> Iterator[str]:
    """The model part, piece by piece."""
    yield (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en-US" '
        f'xmlns="{CORE}" xmlns:bcifs="{NAMESPACE}">\n{metadata}'
        '<resources><object id="1" type="model"><mesh><vertices>\n'
    )
    # adding zero turns -0 into 0
    points = np.round(mesh.points_3d(), 6) + 0.0
    yield from _rows('<vertex x="%.6f" y="%.6f" z="%.6f"/>\n', points)
    yield "</vertices><triangles>\n"
    yield from _rows('<triangle v1="%d" v2="%d" v3="%d"/>\n', mesh.triangles())
    yield '</triangles></mesh></object></resources>\n<build><item objectid="1"/></build></model>\n'


def _rows(pattern: str, table: np.ndarray) -> Iterator[str]:
    for start in range(0, len(table), ROWS):
        part = table[start : start + ROWS]
        yield (pattern * len(part)) % tuple(part.ravel().tolist())
