"""Surfaces to CAD: exact B-spline faces where the limit is polynomial, fitted ones where it is not."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from export.formats.atomic import whole_file
from export.step.error import ENDINGS, WrongEnding
from export.step.facets import facet_leaves
from export.step.fit import surfaces
from export.step.joints import Sheet, joined
from export.step.leaves import leaves
from export.step.loading import load
from export.step.polynomial import Limits
from export.step.solids import is_valid, solid_or_shell, volume
from ifs.complex import Complex, initial
from ifs.shape import Shape
from ifs.surfaces.control_mesh import Surface

MOST_FACETS = 5000

Source = Shape | Surface | Complex


@dataclass(frozen=True)
class StepReport:
    """What left as STEP. Lengths in mm, the volume in mm^3, angles in degrees.

    `exact` faces are the limit surface to rounding; `fitted` ones lie around extraordinary points, `facets`
    are plane triangles. `levels` is how often the extraordinary patches were subdivided, or the mesh of the
    facets. `fit_error` is the largest distance between limit points and fit at equal parameters. `gap` (G0)
    is the largest distance between a face and the edges that it shares; `angle` (G1) the largest angle
    between normals across an edge, creases included, and `angle_fitted` the largest one at a fitted face.
    `closed` says that all parts are solids, `valid` what OpenCASCADE's analyser says. `volume` is that of the
    solids.
    """

    faces: int
    exact: int
    fitted: int
    facets: int
    levels: int
    fit_error: float
    gap: float
    angle: float
    angle_fitted: float
    closed: bool
    valid: bool
    volume: float


def write_step(
    source: Source,
    path: str | os.PathLike[str],
    tolerance: float = 0.01,
    facets: bool = False,
    depth: int = 3,
) -> StepReport:
    """Write a surface as a STEP file in millimetres: solids where it is closed, shells where it is not.

    Polynomial patches leave exactly, as B-spline faces. Patches at extraordinary points are cut into rings
    of exact ones down to a level where a bicubic fit of the last ones lies within `tolerance` (mm) of the
    limit surface. With `facets` the mesh of `depth` subdivisions leaves instead, as plane triangles. The same
    arguments give the same bytes, and the file appears whole or not at all.

    Raises `NotPolynomial` for fractal surfaces and for curves, `TooManyFaces`, `WrongShell` where faces do
    not form an oriented surface, `InsideOut`, `WrongEnding` for a name that ends in neither .step nor .stp,
    `ValueError` for a tolerance that is not positive, and `OSError` where the file cannot be written.

    >>> import ifs, tempfile
    >>> place = Path(tempfile.mkdtemp()) / "patch.step"
    >>> report = write_step(ifs.shape("catmull-clark-patch"), place)
    >>> report.faces, report.exact, report.closed, report.valid
    (1, 1, False, True)
    """
    _require_ending(path)
    sheet, error, level = _sheet(source, tolerance, facets, depth)
    load()
    shape = solid_or_shell(sheet)
    report = _report(sheet, error, level, shape)
    with tempfile.TemporaryDirectory() as folder:
        name = Path(folder) / "part.step"
        _write(shape, name)
        content = name.read_bytes()
    with whole_file(path) as file:
        file.write(content)
    return report


def step_report(source: Source, tolerance: float = 0.01, facets: bool = False, depth: int = 3) -> StepReport:
    """What `write_step` would write, without writing it."""
    sheet, error, level = _sheet(source, tolerance, facets, depth)
    load()
    return _report(sheet, error, level, solid_or_shell(sheet))


def to_build123d(source: Source, tolerance: float = 0.01, facets: bool = False, depth: int = 3) -> Any:
    """The same surface as a build123d `Solid`, `Shell`, or `Compound` of several of them.

    Arguments and errors as for `write_step`.

    >>> import ifs
    >>> to_build123d(ifs.shape("catmull-clark-patch")).area > 900
    True
    """
    sheet, _, _ = _sheet(source, tolerance, facets, depth)
    load()
    import build123d

    shape = solid_or_shell(sheet)
    if len(sheet.closed) > 1:
        return build123d.Compound(shape)
    return build123d.Solid(shape) if all(sheet.closed) else build123d.Shell(shape)


def _require_ending(path: str | os.PathLike[str]) -> None:
    if Path(path).suffix.lower() not in ENDINGS:
        raise WrongEnding(os.fspath(path))


def _sheet(source: Source, tolerance: float, facets: bool, depth: int) -> tuple[Sheet, float, int]:
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"the tolerance is a positive number of millimetres, found {tolerance}")
    complex_ = _complex(source)
    if facets:
        return joined(facet_leaves(complex_, depth, MOST_FACETS)), 0.0, depth
    found = surfaces(Limits(complex_.topology, complex_.system), complex_.control)
    parts, error, level = leaves(complex_, found, tolerance)
    return joined(parts), error, level


def _complex(source: Source) -> Complex:
    if isinstance(source, Complex):
        return source
    if isinstance(source, Surface):
        return source.complex()
    return initial(source.topology, source.system, source.control)


def _report(sheet: Sheet, error: float, level: int, shape: Any) -> StepReport:
    exact = sum(leaf.exact for leaf in sheet.leaves)
    facets = sum(leaf.plane for leaf in sheet.leaves)
    return StepReport(
        faces=len(sheet.leaves),
        exact=exact,
        fitted=len(sheet.leaves) - exact - facets,
        facets=facets,
        levels=level,
        fit_error=error,
        gap=sheet.gap,
        angle=sheet.angle,
        angle_fitted=sheet.angle_fitted,
        closed=all(sheet.closed),
        valid=is_valid(shape),
        volume=volume(shape) if any(sheet.closed) else 0.0,
    )


def _write(shape: Any, name: Path) -> None:
    from build123d import Compound, Unit, export_step

    if not export_step(Compound(shape), name, Unit.MM, timestamp="1970-01-01T00:00:00"):
        raise OSError(f"{name}: OpenCASCADE could not write the file")
