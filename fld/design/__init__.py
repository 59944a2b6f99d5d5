"""Design: members of families whose curves are as rough, and leave in such directions, as asked."""

from fld.design.inverse import Asked, Fit, OutOfReach, fit_behaviour
from fld.design.wishes import CriticalOrder, Leaves

__all__ = ["Asked", "CriticalOrder", "Fit", "Leaves", "OutOfReach", "fit_behaviour"]
