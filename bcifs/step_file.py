"""STEP files from the command line: written, and what they hold said."""

import typer

from bcifs.output import writing
from ifs import Complex, Shape, Surface


def write_step_file(
    source: Shape | Surface | Complex, output: str, tolerance: float, facets: bool = False, depth: int = 3
) -> None:
    """Write a STEP file, and tell on standard output how exact it is."""
    from export.step import write_step

    with writing(output):
        report = write_step(source, output, tolerance, facets, depth)
    what = [f"{report.exact} exact", f"{report.fitted} fitted", f"{report.facets} plane"]
    kind = f"a solid of {report.volume:.6g} mm3" if report.closed else "an open shell"
    valid = "valid" if report.valid else "not valid"
    typer.echo(f"{output}: {report.faces} faces ({', '.join(what)}), {kind}, {valid} in OpenCASCADE")
    typer.echo(f"  fitted within {report.fit_error:.3g} mm; largest gap at an edge (G0) {report.gap:.3g} mm")
    angles = f"{report.angle:.3g} degrees, at fitted faces {report.angle_fitted:.3g}"
    typer.echo(f"  largest angle across an edge (G1) {angles}")
