"""What a map of behaviours says, as data, as text, and as the recipe in its picture."""

from collections.abc import Mapping
from importlib.metadata import version

from automata import Automaton
from bcifs.samples import sample
from fld.classes import Region, named
from fld.regions import Map


def map_data(found: Map) -> Mapping[str, object]:
    """What a map says, as plain data: counts of fields, the regions with their facts and a member of each."""
    facts, total = found.facts, found.facts.verdict.size
    places = zip(("contracts", "does not contract", "undecided"), range(3), strict=True)
    return {
        "x": found.family.names[0],
        "y": found.family.names[1],
        "x_range": list(found.ranges[0]),
        "y_range": list(found.ranges[1]),
        "resolution": len(found.x),
        "here": list(found.family.here) if found.family.here else None,
        "shares": {word: float((facts.verdict == k).sum() / total) for word, k in places},
        "contracts_alone": float(facts.alone.sum() / total),
        "regions": [_region_data(found, region) for region in named(found)],
    }


def _region_data(found: Map, region: Region) -> Mapping[str, object]:
    return {
        "number": region.number,
        "joints": region.joints,
        "dominant_eigenvalues": list(region.kinds),
        "ends_on_own_points": region.own,
        "alternates": region.alternates,
        "share": float(region.members.mean()),
        "mirrored_share": float(region.mirrored.mean()),
        "member": list(sample(found, region).place),
    }


def map_text(found: Map) -> str:
    """The same in lines to read: what share of the plane each region takes."""
    data = map_data(found)
    shares = data["shares"]
    assert isinstance(shares, dict)
    rows = [(word, share, "") for word, share in shares.items()]
    rows += [
        (f"region {r.number}", float((r.members | r.mirrored).mean()), "; ".join(r.words))
        for r in named(found)
    ]
    return "\n".join(f"  {word:<18}{100 * share:6.2f} %  {words}".rstrip() for word, share, words in rows)


def map_recipe(automaton: Automaton, found: Map) -> dict[str, str]:
    """How a map was made; no dates, so that runs give equal bytes."""
    (x0, x1), (y0, y1) = found.ranges
    x, y = found.family.names
    values = ", ".join(f"{key} = {value}" for key, value in automaton.values.items())
    texts = {
        "Name": automaton.name,
        "Map": f"{x} from {x0:g} to {x1:g}, {y} from {y0:g} to {y1:g}, {len(found.x)} fields a side",
        "Values": values,
        "Application": f"bcifs {version('bcifs')}",
    }
    return {key: text for key, text in texts.items() if text}
