"""What `bcifs fld` tells about a vertex of a patch, or about a point of a product of two curves."""

from typing import Any

import numpy as np

from fld.surfaces import Patches, patches, product, product_point, quarters, vertex
from fld.surfaces.products import SIDES
from fld.wording import written
from ifs import Shape
from ifs.complex import refine_traced
from ifs.orbits.addresses import Address, parse_address, path_of, vertex_address

_DEEPEST = 5
_MARK = "@"
_READ = (
    "a patch is looked at in a corner of a piece: '0' or '1 (2)*' is the address of its point, '1 2 @ 3' is "
    "corner 3 of the piece 1 2, '@ 0' corner 0 of the whole"
)


class NoCorner(ValueError):
    """An address that names no corner of a piece of a patch."""


def patch_data(shape: Shape, address: str) -> dict[str, Any]:
    """How the patches around a corner of a piece leave it, as plain data.

    The address is that of a point which is a corner of a piece, `"0"` or `"1 (2)*"`, or names the corner:
    `"1 2 @ 3"` is corner 3 of the piece 1 2, in the order of `ifs.draw`, `"@ 0"` one of the whole.

    Raises `NoCorner`, and what `fld.surfaces.patches` raises.

    >>> import ifs
    >>> patch_data(ifs.shape("catmull-clark-patch"), "0 @ 2")["joint"]
    'smooth'
    """
    surface = patches(shape)
    try:
        word, corner = _corner(shape, surface, address)
    except ValueError as error:
        raise NoCorner(f"{error}; {_READ}") from None
    complex_, cell, number = surface.complex, shape.system.shape, 0
    for label in word:
        complex_, numbers = refine_traced(complex_)
        number = int(numbers(cell, label, np.array([number]))[0])
        cell = shape.automaton.cells[cell].subdivision[label]
    refined = Patches(complex_, surface.ground, surface.frames)
    here = next(n for n, around in refined.faces.items() if (cell, number, corner) in around)
    found = vertex(refined, here).as_data()
    del found["vertex"]
    return {"kind": "patch", "name": shape.name, "address": f"{' '.join((*word, _MARK))} {corner}", **found}


def patch_text(found: dict[str, Any]) -> str:
    """The same as lines to read."""
    joint = found["joint"] or "none: a tangent plane is missing"
    rows = [("point", _point(found["point"])), ("joint", joint)]
    if found["normal"] is not None:
        rows.append(("normal", written(np.array(found["normal"]))))
    if found["turn"]:
        rows.append(("turn", f"{found['turn']:.6g} degrees between normals"))
    for corner in found["corners"]:
        rows.append((f"{corner['cell']} {corner['piece']}, corner {corner['corner']}", corner["words"]))
        for name, side in zip(("to the next", "to the one before"), corner["sides"], strict=True):
            rows.append((f"  edge {name}", side["words"]))
    word, corner = (part.strip() for part in found["address"].split(_MARK))
    where = f"corner {corner} of {f'the piece {word}' if word else 'the whole'}"
    return _lines(f"{found['name']} at {found['address']}: {where}", rows)


def _corner(shape: Shape, surface: Patches, address: str) -> tuple[tuple[str, ...], int]:
    """The piece, as a word, and the number of its corner."""
    if _MARK in address:
        return _marked(shape, surface, address)
    where = parse_address(address)
    path_of(shape.system, where)
    cell = shape.system.shape
    for place in range(len(where.word) + len(where.repeat)):
        for number, corner in enumerate(surface.frames[cell].corners):
            if where.after(place) == vertex_address(shape, cell, corner):
                return _shallow(tuple(where.label(k) for k in range(place))), number
        cell = shape.automaton.cells[cell].subdivision[where.label(place)]
    raise NoCorner(f"the point {where} is no corner of a piece")


def _marked(shape: Shape, surface: Patches, address: str) -> tuple[tuple[str, ...], int]:
    text, _, number = (part.strip() for part in address.partition(_MARK))
    word = tuple(text.split())
    cell = shape.system.shape
    if word:
        path_of(shape.system, Address(word[:-1], word[-1:]))
        for label in word:
            cell = shape.automaton.cells[cell].subdivision[label]
    count = len(surface.frames[cell].corners)
    if not number.isascii() or not number.isdigit() or int(number) >= count:
        raise NoCorner(f"corner {number!r} in {address!r}: expected a number from 0 to {count - 1}")
    return _shallow(word), int(number)


def _shallow(word: tuple[str, ...]) -> tuple[str, ...]:
    if len(word) > _DEEPEST:
        raise NoCorner(
            f"the piece {' '.join(word)} is {len(word)} subdivisions deep; patches are looked at down to "
            f"{_DEEPEST}, where they behave as at any other depth"
        )
    return word


def product_data(first: Shape, second: Shape, address: str) -> dict[str, Any]:
    """The four quarters of a tensor product of two curves at a point, as plain data.

    The address holds one for each curve, with a comma between them: `"1 0, 0 (1 0)*"`. Raises what
    `fld.surfaces.product` and `product_point` raise.

    >>> import ifs
    >>> product_data(ifs.shape("corner-cutting"), ifs.shape("takagi-curve"), "1 0, 1 0")["joint"]
    'fold along u'
    """
    texts = address.split(",")
    if len(texts) != 2:
        raise ValueError(
            f"the address {address!r}: a point of a product of curves has two, with a comma between them, "
            f"as in '1 0, 0'"
        )
    at = product_point(product(first, second), texts[0], texts[1])
    met = quarters(at)
    sections = {
        name: {side: None if (own := found[side]) is None else own.drawn.as_data() for side in SIDES}
        for name, found in (("u", at.u), ("v", at.v))
    }
    return {
        "kind": "product",
        "name": f"{first.name} times {second.name}",
        "addresses": list(at.addresses),
        "parameters": list(at.parameters),
        "point": [float(x) for x in at.point],
        "joint": met.joint,
        "angles": list(met.angles),
        "quarters": [quarter.as_data() for quarter in met.quarters],
        "sections": sections,
    }


def product_text(found: dict[str, Any]) -> str:
    """The same as lines to read."""
    places = ", ".join(f"{place:.9g}" for place in found["parameters"])
    rows = [("point", f"{_point(found['point'])}, parameters ({places})")]
    for name, sections in found["sections"].items():
        for side, own in sections.items():
            said = "none: the surface ends here" if own is None else f"{own['status']}: {own['words']}"
            rows.append((f"along {name}, {side}", said))
    for quarter in found["quarters"]:
        rows.append(("u {}, v {}".format(*quarter["sides"]), quarter["words"]))
    if found["joint"]:
        rows.append(("joint", found["joint"]))
    return _lines(f"{found['name']} at {', '.join(found['addresses'])}", rows)


def is_patch(shape: Shape) -> bool:
    """Whether the shape's cell has three corners or more and is cut into the like."""
    from ifs import NotParametrised

    try:
        patches(shape)
    except (NotParametrised, ValueError):
        return False
    return True


def _point(point: list[float]) -> str:
    return f"{written(np.array(point))} mm"


def _lines(title: str, rows: list[tuple[str, str]]) -> str:
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join([title, *(f"  {name:<{width}}{text}" for name, text in rows)])
