"""Pictures of shapes and parts: how they are seen, what draws them, what is written into them."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from bcifs.depth import Drawn, drawn
from bcifs.progress import silent
from bcifs.recipe import recipe as recipe_of
from ifs import Mesh, Shape

ENDINGS = (".png", ".svg")


class WrongPicture(ValueError):
    """A picture that cannot be drawn of this shape, or in this format."""


def draw_shape(
    shape: Shape,
    path: str | os.PathLike[str],
    *,
    depth: int | None = None,
    progress: Callable[[str, float], None] = silent,
) -> Drawn:
    """Draw a shape into a PNG or SVG file, and return the mesh that was drawn and its depth.

    Name, depth, values and version are written into the file. Without a depth it goes as deep as can be
    seen. Raises `WrongPicture` as `draw_mesh` does, `TooDeep` for a depth out of reach.

    >>> import pathlib, tempfile
    >>> from ifs import shape
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "koch.svg"
    >>> draw_shape(shape("koch-curve"), place, depth=3).kind, place.read_text()[:4]
    ('segments', '<svg')
    """
    made = drawn(shape, depth, progress)
    progress("draw", 0.0)
    draw_mesh(made.mesh, path, recipe_of(shape, made.detail))
    progress("draw", 1.0)
    return made


def draw_mesh(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None) -> None:
    """Draw a mesh (mm) into a PNG or SVG file: from above if plane, else from the front, right and above.

    The recipe is written into the file (PNG text, SVG metadata). The same mesh gives the same picture on the
    same machine; SVG pictures and PNG pictures of plane meshes are the same on all. Raises
    `WrongPicture` for another ending, for faces in space as SVG, more than three coordinates, positions
    that are not finite.
    """
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise WrongPicture(f"{path}: draw .png or .svg")
    if mesh.vertices.shape[1] > 3:
        raise WrongPicture(f"a picture needs 1 to 3 coordinates; here are {mesh.vertices.shape[1]}")
    if not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise WrongPicture("the mesh is empty, or has positions that are not finite")
    if is_plane(mesh):
        from bcifs.flat import write_flat

        write_flat(Mesh(mesh.points_3d()[:, :2], mesh.faces), path, recipe or {})
    elif ending == ".svg":
        from bcifs.flat import write_flat
        from bcifs.view import seen

        if mesh.faces.shape[1] > 2:
            raise WrongPicture(
                f"{path}: SVG is for curves and plane shapes; draw surfaces and solids as .png"
            )
        write_flat(Mesh(seen(mesh.points_3d())[:, :2], mesh.faces), path, recipe or {})
    else:
        from bcifs.scene import write_scene

        write_scene(mesh, path, recipe or {})


def is_plane(mesh: Mesh) -> bool:
    """Whether the mesh lies in a plane z = constant."""
    return bool(np.ptp(mesh.points_3d()[:, 2]) == 0)
