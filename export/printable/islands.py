"""Islands: the components of a part kept, dropped, or linked by struts."""

from dataclasses import dataclass

from export.meshing.skin import EmptySolid
from export.printable.frame import check_above, check_not_below, check_solid
from export.printable.regions import Region, regions
from export.printable.struts import Strut, linked
from trees import Tree
from trees.topology import components

RULES = ("keep", "largest", "link")


@dataclass(frozen=True)
class Islands:
    """The components that stayed and those that went, each from the largest on, and the struts added."""

    kept: tuple[Region, ...]
    dropped: tuple[Region, ...]
    struts: tuple[Strut, ...]


def islands(
    tree: Tree,
    rule: str = "keep",
    *,
    smallest_mm3: float = 0.0,
    diameter_mm: float | None = None,
    metric: str = "d1",
) -> tuple[Tree, Islands]:
    """The components of a part, by a rule: keep them, keep the largest, or link them by struts.

    Components of less than `smallest_mm3` are dropped first. Cells touch across faces ("d1"), or, where
    contacts will be joined, across edges and corners too ("d-infinity"). "link" adds the struts of a
    minimum spanning tree: its lengths are the distances between the nearest cells of two components, centre
    to centre; of equally short struts one amid them is taken. A strut is the sum of a line of cells, each
    across a face from the next, and of a Ball of radius `diameter_mm / 2` in cells: it is connected, and its
    diameter is right within one cell. The result is then one component. The cube grows where a strut
    reaches out of it.

    Raises `EmptySolid` where nothing is left, `WrongLength` for a volume below 0 or a diameter that is not
    above 0, `ValueError` for another rule or a missing diameter, `TreeError` for another metric.

    >>> from trees import from_points
    >>> two = from_points([[0, 0, 0], [3, 0, 0]], bits=2)
    >>> tree, report = islands(two, "link", diameter_mm=0.25)
    >>> tree.count, report.struts[0].length
    (4, 0.75)
    """
    if rule not in RULES:
        raise ValueError(f"the rule for islands is one of {', '.join(RULES)}; found {rule!r}")
    check_solid(tree)
    check_not_below("the smallest volume in mm^3", smallest_mm3)
    if rule == "link" and diameter_mm is None:
        raise ValueError("islands are linked by struts of a diameter: give diameter_mm")
    if diameter_mm is not None:
        check_above("the diameter in mm", diameter_mm)
    found = components(tree, metric)
    every = regions(found)
    count = sum(region.volume >= smallest_mm3 for region in every)
    if count == 0:
        raise EmptySolid(
            f"the largest of {len(every)} islands has {every[0].volume:.6g} mm^3, and islands of less than "
            f"{smallest_mm3:.6g} mm^3 are dropped: ask for less"
        )
    count = 1 if rule == "largest" else count
    kept = tree if count == len(every) else found.tree_of(range(count))
    struts: tuple[Strut, ...] = ()
    if rule == "link" and diameter_mm is not None and count > 1:
        kept, struts = linked(kept, found, diameter_mm)
    return kept, Islands(every[:count], every[count:], struts)
