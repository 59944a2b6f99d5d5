"""Making a part printable: islands, voids, hollows, bases, least walls and gaps, build volumes."""

from export.printable.base import Base, with_base
from export.printable.drains import Drain, drained
from export.printable.fitting import DoesNotFit, Fit, fits, turned, turns
from export.printable.frame import WrongLength
from export.printable.hollow import Hollow, hollowed
from export.printable.islands import Islands, islands
from export.printable.narrow import Narrow, gaps_at_least, least_wall, thin_walls, tight_gaps, walls_at_least
from export.printable.regions import Region
from export.printable.requests import Printable
from export.printable.steps import Made, Step, made_printable
from export.printable.struts import Strut
from export.printable.voids import filled, voids

__all__ = [
    "Base",
    "DoesNotFit",
    "Drain",
    "Fit",
    "Hollow",
    "Islands",
    "Made",
    "Narrow",
    "Printable",
    "Region",
    "Step",
    "Strut",
    "WrongLength",
    "drained",
    "filled",
    "fits",
    "gaps_at_least",
    "hollowed",
    "islands",
    "least_wall",
    "made_printable",
    "thin_walls",
    "tight_gaps",
    "turned",
    "turns",
    "voids",
    "walls_at_least",
    "with_base",
]
