"""A picture of a mesh in which its faults and its thinnest places are marked."""

import os

import numpy as np
from jaxtyping import Float

from bcifs.palette import CLAY, INK, PAPER
from bcifs.png import write_png
from bcifs.view import axes, seen, sheet
from export.checks.report import Report
from ifs import Mesh

FAULT = "#c0392b"
NOTE = "#d9a021"
THIN = "#7d3c98"
FINER = 2  # each pixel is rendered as 2 x 2
MARK = 22  # pixels across
MOST = 2_000_000  # triangles that are drawn; of more, every n-th
LINES = 8  # of the legend
SHADE = 0.30


def draw_faults(mesh: Mesh, report: Report, path: str | os.PathLike[str]) -> None:
    """Draw a mesh (mm) as if of glass into a PNG file, with dots where something is wrong.

    Red dots are faults, yellow ones notes, violet ones the thinnest wall and the narrowest gap; a
    legend names them. They are seen through the mesh. Up to 500 of each kind are marked.
    """
    from PIL import Image, ImageDraw

    page = sheet(seen(mesh.points_3d())[:, :2])
    picture = Image.fromarray(_glass(mesh)).reduce(FINER)
    brush = ImageDraw.Draw(picture)
    groups = marks(report)
    right_up = axes(mesh.points_3d())[:2]
    for _, colour, places in reversed(groups):
        for x, y in page.place(places @ right_up.T) if len(places) else ():
            r = MARK / 2
            brush.ellipse((x - r, y - r, x + r, y + r), outline=PAPER, fill=None, width=6)
            brush.ellipse((x - r, y - r, x + r, y + r), outline=colour, fill=None, width=3)
            brush.ellipse((x - 3, y - 3, x + 3, y + 3), fill=colour)
    for line, (words, colour, _) in enumerate(groups[:LINES]):
        brush.ellipse((20, 22 + 28 * line, 34, 36 + 28 * line), fill=colour)
        brush.text((44, 18 + 28 * line), words, fill=INK, font_size=18)
    write_png(picture, path, {"Verdict": "printable" if report.ok else "not printable"})


def marks(report: Report) -> list[tuple[str, str, Float[np.ndarray, "n 3"]]]:
    """Words, colour and places (mm) of all that is marked; faults first."""
    found = [
        (f"{one.count} {one.meaning}", colour, np.array(one.marks, dtype=float).reshape(-1, 3))
        for group, colour in ((report.details, FAULT), (report.notes, NOTE))
        for one in group
    ]
    for name, narrow in (("thinnest wall", report.walls), ("narrowest gap", report.gaps)):
        if narrow:
            found.append((f"{name} {narrow[0].width:.3g} mm", THIN, np.array([narrow[0].place])))
    return found or [("nothing to mark", INK, np.zeros((0, 3)))]


def _glass(mesh: Mesh) -> np.ndarray:
    """The mesh by itself, translucent and with its creases, without perspective."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)  # that there is no display is no news
    points, triangles = mesh.points_3d(), mesh.triangles()
    page = sheet(seen(points)[:, :2])
    right, up, towards = axes(points)
    shown = Mesh(points, triangles[:: -(-len(triangles) // MOST)]).to_pyvista()
    plotter = pyvista.Plotter(
        off_screen=True, window_size=[page.width * FINER, page.height * FINER], lighting="none"
    )
    try:
        plotter.renderer.set_background(PAPER)
        plotter.add_mesh(shown, color=CLAY, opacity=SHADE, lighting=False)
        creases = shown.extract_feature_edges(30.0, manifold_edges=False)
        if creases.n_cells:
            plotter.add_mesh(creases, color=INK, opacity=SHADE, line_width=FINER, lighting=False)
        depth = points @ towards
        middle = right * page.centre[0] + up * page.centre[1] + towards * (depth.min() + depth.max()) / 2
        camera = plotter.camera
        camera.parallel_projection = True
        camera.focal_point = tuple(middle)
        camera.position = tuple(middle + 3 * (float(np.ptp(points, axis=0).max()) or 1.0) * towards)
        camera.up = tuple(up)
        camera.parallel_scale = page.height / page.scale / 2
        plotter.renderer.ResetCameraClippingRange()
        return np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()
