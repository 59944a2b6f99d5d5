"""Densities as volume files: OpenVDB for renderers, VTK images for measuring."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float

from export.formats.atomic import whole_file
from export.formats.endings import UnsupportedFormat
from export.formats.openvdb import write_grid
from ifs.measures.grid import Density

ENDINGS = (".vdb", ".vti")


def write_volume(
    density: Density,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    name: str = "density",
) -> None:
    """Write the mass by volume (mm^-3; the opacity, for `export.vapour`) of each cell, in 32 bits.

    `.vdb` is an OpenVDB fog volume with the cells that are not 0, `.vti` a VTK image with cell data; both
    keep place and size in mm and the recipe. A plane density becomes one layer of cells around z = 0, mass
    by mm^2. Whole or not at all; the same arguments give the same bytes. Raises `UnsupportedFormat` for
    another ending, `ValueError` for amounts that are not finite in 32 bits, `OSError`.

    >>> import tempfile
    >>> from ifs.measures.grid import Grid
    >>> place = Path(tempfile.mkdtemp()) / "four.vti"
    >>> write_volume(Density(Grid(np.zeros(2), 2.0, (2, 2)), np.full((2, 2), 0.25)), place)
    >>> import pyvista
    >>> pyvista.read(place)["density"].tolist()
    [0.0625, 0.0625, 0.0625, 0.0625]
    """
    check_writable(path)
    if not isinstance(density, Density):
        raise ValueError(f"a Density is written, found a {type(density).__name__}: sets go to write_cells")
    values, origin = _in_space(density)
    if not np.isfinite(values).all():
        raise ValueError("the density has amounts that are not finite in 32 bits; scale it")
    pitch = density.grid.pitch
    if Path(path).suffix.lower() == ".vdb":
        with whole_file(path) as file:
            write_grid(file, values, origin, pitch, recipe or {}, name)
    else:
        text = _image(values, origin, pitch, recipe or {}, name)
        with whole_file(path) as file:
            file.write(text.encode("utf-8"))


def check_writable(path: str | os.PathLike[str]) -> None:
    """`UnsupportedFormat` unless `write_volume` knows the ending: to ask before a long run."""
    if Path(path).suffix.lower() not in ENDINGS:
        raise UnsupportedFormat(f"{path}: write {', '.join(ENDINGS)}")


def _in_space(density: Density) -> tuple[Float[np.ndarray, "x y z"], Float[np.ndarray, "3"]]:
    with np.errstate(over="ignore"):
        values = (density.amounts / density.grid.cell).astype(np.float32)
    origin = density.grid.origin
    if values.ndim == 2:
        return values[:, :, None], np.array([*origin, -density.grid.pitch / 2])
    return values, origin


def _image(
    values: Float[np.ndarray, "x y z"],
    origin: Float[np.ndarray, "3"],
    pitch: float,
    recipe: Mapping[str, str],
    name: str,
) -> str:
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    corners = tuple(size + 1 for size in values.shape)
    image = pyvista.ImageData(dimensions=corners, spacing=(pitch,) * 3, origin=tuple(origin.tolist()))
    image.cell_data[name] = values.ravel(order="F")
    for key, value in recipe.items():
        image.field_data[f"bcifs:{key}"] = [value]
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(image)
    writer.WriteToOutputStringOn()
    writer.Write()
    return writer.GetOutputString()
