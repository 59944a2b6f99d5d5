"""All that makes a part printable, one step after the other, and what each of them did."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from export.meshing.joining import join_contacts
from export.meshing.skin import Field
from export.printable.base import with_base
from export.printable.drains import Drain, drained
from export.printable.fields import agreeing, turned_field
from export.printable.fitting import DoesNotFit, Turn, fits, turned, turns
from export.printable.frame import box_of, cells_up, check_solid, mm_of
from export.printable.hollow import hollowed
from export.printable.islands import islands
from export.printable.narrow import gaps_at_least, least_wall, thin_walls, tight_gaps, walls_at_least
from export.printable.regions import Region
from export.printable.requests import UP, Printable
from export.printable.voids import voids
from trees import Tree

ROUNDS = 4  # of boring and joining, after which voids that are closed again stay
RULES = {"keep": "keep", "drop": "largest", "link": "link"}


@dataclass(frozen=True)
class Step:
    """What was done to a part: the name of the step, a line of words, and the figures in it (mm, mm^3)."""

    name: str
    words: str
    figures: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.name}: {self.words}"


@dataclass(frozen=True, eq=False)
class Made:
    """A part, its field if it has one (see `export.meshing.skin`), and what was done to it, in order."""

    tree: Tree
    field: Field | None
    steps: tuple[Step, ...] = ()


Told = Callable[[str, float], None]


def made_printable(
    tree: Tree,
    asked: Printable,
    field: Field | None = None,
    contacts: str = "join",
    progress: Told | None = None,
) -> Made:
    """A part with all that is asked done to it, in the order of the fields of `Printable`.

    Where contacts will be joined ("join"), voxels that touch at an edge or a corner belong to one island, and
    drains are bored once they are joined, again where that closes one. `field` stays what it is where voxels
    stay what they were; next to others the surface lies half-way between the centres of voxels.

    Raises what the steps raise: `EmptySolid` for the empty set, or where nothing is left, `DoesNotFit`,
    `TreeError` where the tree is not of dimension 3, `KeyTooWide` where the cube would get too many cells.

    >>> from trees import full, unit_cube
    >>> made = made_printable(full(unit_cube(3), bits=4), Printable(hollow=0.25, drain=0.1))
    >>> for step in made.steps:
    ...     print(step)
    hollow: walls of 0.25 mm; 1 cavity of 0.125 mm^3 taken out
    drain: 1 hole of 0.1 mm, 0.312 mm long at most; no void is left
    """
    check_solid(tree)
    made = Made(tree, field)
    done = [step for name, step in STEPS if _is_asked(asked, name)]
    for number, step in enumerate(done):
        if progress is not None:
            progress("printable", number / len(done))
        made = step(made, asked, contacts == "join")
    made = _told_what_is_left(made, asked)
    if made.field is not None and made.tree is not tree:
        made = replace(made, field=agreeing(made.field, made.tree))
    if progress is not None and done:
        progress("printable", 1.0)
    return made


def _is_asked(asked: Printable, name: str) -> bool:
    if name == "islands":
        return asked.islands != "keep" or asked.smallest > 0
    return getattr(asked, name) != getattr(Printable, name)


def _then(made: Made, tree: Tree, name: str, words: str, **figures: float) -> Made:
    return Made(tree, made.field, (*made.steps, Step(name, words, figures)))


def _walls(made: Made, asked: Printable, joined: bool) -> Made:
    limit = asked.wall or 0.0
    thin, before = thin_walls(made.tree, limit)
    figures = {"limit": limit, "places": len(before.places)}
    if not thin:
        return _then(made, made.tree, "walls", f"none found thinner than {limit:g} mm", **figures)
    least = least_wall(made.tree, limit)
    tree, _ = walls_at_least(made.tree, limit)
    added = tree.measure - made.tree.measure
    words = (
        f"{_count(len(before.places), 'place')} thinner than {limit:g} mm, the thinnest of about "
        f"{least:.3g} mm, made as thick, to about a voxel; {added:.4g} mm^3 added"
    )
    return _then(made, tree, "walls", words, **figures, least_before=least, least_after=limit, added=added)


def _gaps(made: Made, asked: Printable, joined: bool) -> Made:
    limit = asked.gap or 0.0
    tree, before = gaps_at_least(made.tree, limit)
    figures = {"limit": limit, "places": len(before.places)}
    if not before.places:
        return _then(
            made,
            made.tree,
            "gaps",
            f"none found narrower than {limit:g} mm, corners and short tunnels aside",
            **figures,
        )
    added = tree.measure - made.tree.measure
    words = f"{_count(len(before.places), 'place')} narrower than {limit:g} mm filled; {added:.4g} mm^3 added"
    return _then(made, tree, "gaps", words, **figures, added=added)


def _islands(made: Made, asked: Printable, joined: bool) -> Made:
    strut = asked.strut or max(asked.wall or 0.0, 2 * made.tree.cell_size)
    tree, told = islands(
        made.tree,
        RULES[asked.islands],
        smallest_mm3=asked.smallest,
        diameter_mm=strut if asked.islands == "link" else None,
        metric="d-infinity" if joined else "d1",
    )
    lost = sum(region.volume for region in told.dropped)
    found = len(told.kept) + len(told.dropped)
    figures = {
        "found": found,
        "dropped": len(told.dropped),
        "dropped_volume": lost,
        "struts": len(told.struts),
    }
    words = [f"{found} found" if found != 1 else "the part is in one piece"]
    if told.dropped:
        words.append(f"{len(told.dropped)} dropped with {lost:.3g} mm^3")
    if told.struts:
        longest = max(one.length for one in told.struts)
        figures |= {"strut": strut, "longest": longest}
        count = _count(len(told.struts), "strut")
        words.append(f"linked by {count} of {strut:.3g} mm, {longest:.3g} mm long at most")
    return _then(made, tree, "islands", ", ".join(words), **figures)


def _hollow(made: Made, asked: Printable, joined: bool) -> Made:
    tree, told = hollowed(made.tree, asked.hollow or 0.0)
    volume = sum(region.volume for region in told.cavities)
    figures = {"wall": told.wall, "cavities": len(told.cavities), "volume": volume}
    if not told.cavities:
        words = f"nowhere twice as thick as walls of {told.wall:.3g} mm; left as it is"
        return _then(made, made.tree, "hollow", words, **figures)
    cavities = _count(len(told.cavities), "cavity", "cavities")
    words = f"walls of {told.wall:.3g} mm; {cavities} of {volume:.4g} mm^3 taken out"
    words += "" if asked.drain else "; the way out is closed, drains open it"
    return _then(made, tree, "hollow", words, **figures)


def _turn(made: Made, asked: Printable, joined: bool) -> Made:
    turn = _chosen(made.tree, asked)
    if turn == turns()[0]:
        return _then(made, made.tree, "turn", "it stands well as it is", turned=0)
    rows = (
        "".join(f"{'-' if n < 0 else ''}{axis}" for n, axis in zip(row, "xyz", strict=True) if n)
        for row in turn
    )
    tree = turned(made.tree, turn)
    low, high = mm_of(tree, box_of(tree) + np.array([[0], [1]]))
    place = " to ".join("(" + ", ".join(f"{x:.4g}" for x in corner) + ")" for corner in (low, high))
    follows = None if made.field is None else turned_field(made.field, made.tree, turn)
    return _then(
        replace(made, field=follows),
        tree,
        "turn",
        f"(x, y, z) is now ({', '.join(rows)}), from {place} mm",
        turned=1,
    )


def _chosen(tree: Tree, asked: Printable) -> Turn:
    if asked.turn == "fit" and asked.fit is not None:
        height = asked.fit[2] - (cells_up(tree, asked.base) * tree.cell_size if asked.base else 0.0)
        if height <= 0:
            raise DoesNotFit(
                asked.fit, fits(tree, asked.fit), f"a base of {asked.base:g} mm alone is as high"
            )
        return fits(tree, (*asked.fit[:2], height)).turn
    return next(turn for turn in turns() if tuple(turn[2]) == UP[asked.turn])


def _base(made: Made, asked: Printable, joined: bool) -> Made:
    tree, told = with_base(made.tree, asked.base or 0.0, asked.margin)
    height = told.high[2] - told.low[2]
    sides = " x ".join(f"{high - low:.4g}" for low, high in zip(told.low[:2], told.high[:2], strict=True))
    words = f"{sides} mm, {height:.3g} mm high; the part stands on {told.contact:.4g} of {told.area:.4g} mm^2"
    return _then(made, tree, "base", words, height=height, area=told.area, contact=told.contact)


def _drain(made: Made, asked: Printable, joined: bool) -> Made:
    tree, found = made.tree, list[Drain]()
    for _ in range(ROUNDS):
        tree = join_contacts(tree) if joined else tree
        tree, bored = drained(tree, asked.drain or 0.0)
        found += bored
        if not bored:
            break
    left = len(voids(join_contacts(tree) if joined else tree))
    figures = {"diameter": asked.drain or 0.0, "drains": len(found), "voids_left": left}
    if not found:
        return _then(made, made.tree, "drain", "there is no trapped void", **figures)
    longest = max(one.length for one in found)
    words = (
        f"{_count(len(found), 'hole')} of {asked.drain:g} mm, {longest:.3g} mm long at most; "
        f"{'no void is' if left == 0 else _count(left, 'void')} left"
    )
    return _then(made, tree, "drain", words, **figures, longest=longest)


def _fit(made: Made, asked: Printable, joined: bool) -> Made:
    room = asked.fit or (0.0, 0.0, 0.0)
    found = fits(made.tree, room)
    sides = np.array(found.sides)
    if (sides > np.array(room) * (1 + 1e-9)).any():
        other = found.fits and asked.turn != "fit"
        raise DoesNotFit(room, found, "turned otherwise it does: ask for the turn 'fit'" if other else "")
    share = float((sides / np.array(room)).max())
    words = f"{_sides(sides)} mm fit into {_sides(room)} mm"
    return _then(made, made.tree, "fit", words, share=share)


def _told_what_is_left(made: Made, asked: Printable) -> Made:
    """Walls and gaps below the limit that steps after the first two brought about."""
    changed = any(step.name in ("gaps", "islands", "hollow", "base", "drain") for step in made.steps)
    if asked.wall and changed:
        made = _left(made, "thin-walls", asked.wall, thin_walls(made.tree, asked.wall)[1].places, "thinner")
    if asked.gap and changed:
        made = _left(made, "tight-gaps", asked.gap, tight_gaps(made.tree, asked.gap)[1].places, "narrower")
    return made


def _left(made: Made, name: str, limit: float, places: tuple[Region, ...], than: str) -> Made:
    if not places:
        return made
    where = ", ".join(f"{x:.3g}" for x in places[0].centre)
    number = _count(len(places), "place")
    words = f"{number} {than} than {limit:g} mm after the other steps, the largest at ({where})"
    return _then(made, made.tree, name, words, limit=limit, places=len(places))


def _count(number: int, one: str, many: str | None = None) -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def _sides(lengths) -> str:
    return " x ".join(f"{length:.4g}" for length in lengths)


STEPS: tuple[tuple[str, Callable[[Made, Printable, bool], Made]], ...] = (
    ("wall", _walls),
    ("gap", _gaps),
    ("islands", _islands),
    ("hollow", _hollow),
    ("turn", _turn),
    ("base", _base),
    ("drain", _drain),
    ("fit", _fit),
)
