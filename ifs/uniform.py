"""The mesh of a shape, or of any complex, after the same number of subdivisions everywhere."""

from ifs.asked import require_shape, require_whole
from ifs.complex import Complex, initial, refined
from ifs.drawing import draw
from ifs.mesh import Mesh
from ifs.shape import Shape
from ifs.stamp import stamped, supports
from ifs.stencil import Stencils

DEEPEST = 64


def mesh(shape: Shape, depth: int) -> Mesh:
    """The conformal mesh of a shape after `depth` subdivisions.

    Its vertices are limit points, exact to rounding at any depth; neighbouring pieces share those that
    the automaton glues. A cell without boundary draws the box that bounds it, unless its `figure`
    says otherwise; then pieces share nothing. Raises `ValueError` for a depth that is no whole
    number from 0 to 64.

    >>> from ifs.shape import shape
    >>> curve = mesh(shape("corner-cutting"), 3)
    >>> curve.vertices.shape, curve.faces.shape
    ((9, 2), (8, 2))
    """
    require_shape(shape)
    return uniform(initial(shape.topology, shape.system, shape.control), depth)


def uniform(complex_: Complex, depth: int, stencils: Stencils | None = None) -> Mesh:
    """The conformal mesh of a complex after `depth` subdivisions of all its pieces.

    Stamped from a template of each state, which `stencils` of the same topology and system keeps for the next
    time; drawn piece by piece only where pieces draw the boxes that bound them. Raises `ValueError` for a
    negative depth.

    >>> from ifs.shape import shape
    >>> curve = shape("menger-sponge")
    >>> uniform(initial(curve.topology, curve.system, curve.control), 1).faces.shape
    (120, 4)
    """
    require_depth(depth)
    if supports(complex_, depth):
        return stamped(complex_, depth, stencils).mesh
    return draw(refined(complex_, depth))


def require_depth(depth: int) -> None:
    """Raise `ValueError` for a depth that is no whole number from 0 to 64."""
    require_whole("depth", depth, 0, DEEPEST)
