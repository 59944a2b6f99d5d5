"""Pictures of meshes in space, through pyvista without a window."""

import os
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from bcifs.flat import parts
from bcifs.palette import CLAY, PAPER, WIRE
from bcifs.png import write_png
from bcifs.view import Sheet, axes, seen, sheet
from ifs import Mesh

FINER = 2  # each pixel is rendered as 2 x 2
CREASE = 30.0  # degrees: flatter edges are shaded as if round
WIRE_RADIUS = 0.004  # of the size of the shape
LIGHTS = (  # direction in the eye's axes, and strength
    ((-0.5, 0.7, 0.9), 0.62),
    ((0.9, 0.05, 0.5), 0.30),
    ((-0.3, -0.8, 0.6), 0.28),
)


def write_scene(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
    """Draw a mesh in space without perspective, shaded, on a sheet that it fills."""
    from PIL import Image

    points = mesh.points_3d()
    page = sheet(seen(points)[:, :2])
    pixels = _rendered(mesh, page)
    write_png(Image.fromarray(pixels).reduce(FINER), path, recipe)


def _rendered(mesh: Mesh, page: Sheet) -> np.ndarray:
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)  # that there is no display is no news
    plotter = pyvista.Plotter(
        off_screen=True, window_size=[page.width * FINER, page.height * FINER], lighting="none"
    )
    try:
        plotter.renderer.set_background(PAPER)
        _add(plotter, mesh)
        _light(plotter, mesh.points_3d())
        _aim(plotter, mesh.points_3d(), page)
        size = float(np.ptp(mesh.points_3d(), axis=0).max())
        plotter.renderer.enable_ssao(radius=0.12 * size, bias=0.004 * size, kernel_size=16, blur=True)
        return np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()


def _add(plotter, mesh: Mesh) -> None:
    import pyvista

    points = mesh.points_3d()
    corners = (mesh.faces >= 0).sum(axis=1)
    size = float(np.ptp(points, axis=0).max())
    if (corners > 2).any():
        surface = Mesh(points, mesh.faces[corners > 2]).to_pyvista()
        shaded = surface.compute_normals(
            cell_normals=False, feature_angle=CREASE, split_vertices=True, consistent_normals=False
        )
        plotter.add_mesh(shaded, color=CLAY, smooth_shading=True, ambient=0.22, diffuse=0.85, specular=0.08)
    _, lines, dots = parts(Mesh(points, mesh.faces[corners <= 2]))
    for line in lines:
        curve = pyvista.lines_from_points(points[line])
        tube = curve.tube(radius=WIRE_RADIUS * size, n_sides=16, capping=True)
        plotter.add_mesh(tube, color=WIRE, smooth_shading=True, ambient=0.2, diffuse=0.8, specular=0.2)
    if len(dots):
        plotter.add_mesh(
            pyvista.PolyData(points[dots]), color=CLAY, point_size=4 * FINER, render_points_as_spheres=True
        )


def _light(plotter, points: Float[np.ndarray, "n 3"]) -> None:
    import pyvista

    for direction, strength in LIGHTS:
        towards = np.array(direction) @ axes(points)
        light = pyvista.Light(position=tuple(towards), focal_point=(0, 0, 0), intensity=strength)
        light.positional = False
        plotter.add_light(light)


def _aim(plotter, points: Float[np.ndarray, "n 3"], page: Sheet) -> None:
    """Set the camera so that the picture shows just the sheet."""
    right, up, towards = axes(points)
    depth = points @ towards
    middle = right * page.centre[0] + up * page.centre[1] + towards * (depth.min() + depth.max()) / 2
    distance = float(np.ptp(points, axis=0).max()) * 3
    camera = plotter.camera
    camera.parallel_projection = True
    camera.focal_point = tuple(middle)
    camera.position = tuple(middle + distance * towards)
    camera.up = tuple(up)
    camera.parallel_scale = page.height / page.scale / 2
    plotter.renderer.ResetCameraClippingRange()
