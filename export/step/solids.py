"""Faces, edges and corners as an OpenCASCADE shape: nothing is sewn, neighbours share their edges."""

# OCP's modules are compiled: type checkers do not see their names.
# pyright: reportAttributeAccessIssue=false
from typing import Any

import numpy as np

from export.step.error import InsideOut
from export.step.joints import Sheet, side_parameters

_LEAST = 1e-7  # mm: what OpenCASCADE takes for the same point


def solid_or_shell(sheet: Sheet) -> Any:
    """The `TopoDS_Shape`: a solid for each closed part of the sheet, a shell for each open one.

    A sheet of several parts becomes a compound. Raises `InsideOut` for a closed part of negative volume.
    """
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound, TopoDS_Shell, TopoDS_Solid

    builder = BRep_Builder()
    faces = _faces(sheet)
    parts = []
    for number, closed in enumerate(sheet.closed):
        shell = TopoDS_Shell()
        builder.MakeShell(shell)
        for face in np.flatnonzero(sheet.shell == number):
            builder.Add(shell, faces[face])
        shell.Closed(closed)
        if not closed:
            parts.append(shell)
            continue
        solid = TopoDS_Solid()
        builder.MakeSolid(solid)
        builder.Add(solid, shell)
        if volume(solid) < 0:
            raise InsideOut(volume(solid))
        parts.append(solid)
    if len(parts) == 1:
        return parts[0]
    compound = TopoDS_Compound()
    builder.MakeCompound(compound)
    for part in parts:
        builder.Add(compound, part)
    return compound


def volume(shape: Any) -> float:
    """The volume of the solids of a `TopoDS_Shape`, in mm^3."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return properties.Mass()


def is_valid(shape: Any) -> bool:
    """Whether OpenCASCADE's analyser finds nothing wrong with a `TopoDS_Shape`."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    return bool(BRepCheck_Analyzer(shape).IsValid())


def _faces(sheet: Sheet) -> list[Any]:
    from OCP.BRep import BRep_Builder
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Face, TopoDS_Wire

    builder = BRep_Builder()
    tolerance = max(_LEAST, 2 * sheet.gap)
    edges = _edges(sheet, tolerance)
    result = []
    for leaf in sheet.leaves:
        face, wire = TopoDS_Face(), TopoDS_Wire()
        builder.MakeFace(
            face, _plane(leaf.control) if leaf.plane else _surface(leaf.control), TopLoc_Location(), tolerance
        )
        builder.MakeWire(wire)
        for use in leaf.uses:
            edge = edges[use.edge]
            if not leaf.plane:
                ends = side_parameters(use.side, np.array([use.t0, use.t1]))
                line = _line(ends if use.forward else ends[::-1])
                builder.UpdateEdge(edge, line, face, tolerance)
            builder.Add(wire, edge if use.forward else edge.Reversed())
        wire.Closed(True)
        builder.Add(face, wire)
        result.append(face)
    for edge in edges.values():
        builder.SameRange(edge, True)
        builder.SameParameter(edge, True)
    return result


def _edges(sheet: Sheet, tolerance: float) -> dict[int, Any]:
    from OCP.BRep import BRep_Builder
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Vertex

    builder = BRep_Builder()
    corners = []
    for point in sheet.points.tolist():
        corner = TopoDS_Vertex()
        builder.MakeVertex(corner, gp_Pnt(*point), tolerance)
        corners.append(corner)
    result = {}
    for number, poles in sheet.curves.items():
        edge = TopoDS_Edge()
        builder.MakeEdge(edge, _curve(poles), tolerance)
        first, last = sheet.ends[number]
        builder.Add(edge, corners[first].Oriented(TopAbs_Orientation.TopAbs_FORWARD))
        builder.Add(edge, corners[last].Oriented(TopAbs_Orientation.TopAbs_REVERSED))
        builder.Range(edge, 0.0, 1.0)
        result[number] = edge
    return result


def _curve(poles: np.ndarray) -> Any:
    from OCP.collections import Array1_gp_Pnt
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

    array = Array1_gp_Pnt(1, len(poles))
    for i, point in enumerate(poles.tolist()):
        array.SetValue(i + 1, gp_Pnt(*point))
    return Geom_BSplineCurve(array, *_knots(len(poles) - 1), len(poles) - 1)


def _line(ends: np.ndarray) -> Any:
    from OCP.collections import Array1_gp_Pnt2d
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.gp import gp_Pnt2d

    array = Array1_gp_Pnt2d(1, 2)
    for i, point in enumerate(ends.tolist()):
        array.SetValue(i + 1, gp_Pnt2d(*point))
    return Geom2d_BSplineCurve(array, *_knots(1), 1)


def _surface(control: np.ndarray) -> Any:
    from OCP.collections import Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    u, v = len(control) - 1, control.shape[1] - 1
    array = Array2_gp_Pnt(1, u + 1, 1, v + 1)
    for i, row in enumerate(control.tolist()):
        for j, point in enumerate(row):
            array.SetValue(i + 1, j + 1, gp_Pnt(*point))
    (knots_u, times_u), (knots_v, times_v) = _knots(u), _knots(v)
    return Geom_BSplineSurface(array, knots_u, knots_v, times_u, times_v, u, v)


def _plane(control: np.ndarray) -> Any:
    from OCP.Geom import Geom_Plane
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

    along, across = control[1, 0] - control[0, 0], control[0, 1] - control[0, 0]
    normal = np.cross(along, across)
    frame = gp_Ax3(gp_Pnt(*control[0, 0].tolist()), gp_Dir(*normal.tolist()), gp_Dir(*along.tolist()))
    return Geom_Plane(frame)


def _knots(degree: int) -> tuple[Any, Any]:
    """The knots of a single polynomial piece, and their multiplicities."""
    from OCP.collections import Array1_double, Array1_int

    knots, times = Array1_double(1, 2), Array1_int(1, 2)
    for i, knot in enumerate((0.0, 1.0)):
        knots.SetValue(i + 1, knot)
        times.SetValue(i + 1, degree + 1)
    return knots, times
