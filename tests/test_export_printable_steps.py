"""All that makes a part printable in turn: requests, what is told, and fields that follow."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from export.meshing.joining import join_contacts
from export.meshing.skin import skin
from export.printable import Printable, WrongLength, least_wall, made_printable, turned, turns, voids
from export.printable.fields import agreeing, turned_field
from export.thicken import thicken
from trees import Cube, Tree, from_points, full, to_points, unit_cube

small = hnp.arrays(bool, (6, 6, 6)).filter(np.any)


def solid(array: np.ndarray) -> Tree:
    return from_points(np.argwhere(array), 3, Cube((-1.0, 0.5, 2.0), 2.4))


def centres(tree: Tree) -> np.ndarray:
    return np.array(tree.origin) + (to_points(tree) + 0.5) * tree.cell_size


@settings(max_examples=20, deadline=None)
@given(one=small, other=small)
def test_an_agreeing_field_has_the_sign_of_the_set(one, other):
    old, new = solid(one), solid(other)
    field = agreeing(thicken(old, 0.0).field, new)
    everywhere = centres(full(new.cube, new.bits))
    values = field(everywhere)
    assert np.array_equal(values <= 0, new.holds(everywhere))
    same = old.holds(everywhere) == new.holds(everywhere)
    assert np.array_equal(values[same], thicken(old, 0.0).field(everywhere)[same])


def test_a_surface_next_to_new_cells_lies_half_way():
    """A slab with one more layer on top, all of it new: the top of the smooth surface is flat."""
    slab = solid(np.arange(6)[None, None, :] * np.ones((6, 6, 1)) == 2)
    thick = thicken(slab, 0.45)
    more = thick.tree | from_points(
        to_points(thick.tree).astype(int) + np.array([0, 0, 1]), thick.tree.bits, thick.tree.cube
    )
    mesh = skin(more, "smooth", field=agreeing(thick.field, more))
    top = mesh.vertices[:, 2].max()
    pitch = slab.cell_size
    faces = (mesh.vertices[:, 2] > top - 0.6 * pitch) & (
        abs(mesh.vertices[:, :2] - [-0.1, 1.4]).max(axis=1) < 0.6
    )
    highest = (to_points(more)[:, 2].max() + 1) * pitch + more.origin[2]
    np.testing.assert_allclose(mesh.vertices[faces, 2], highest, atol=1e-9)


@settings(max_examples=10, deadline=None)
@given(array=small, number=st.integers(0, 23))
def test_a_turned_field_is_that_of_the_turned_set(array, number):
    tree, turn = solid(array), turns()[number]
    moved = turned(tree, turn)
    everywhere = centres(full(tree.cube, tree.bits))
    follows = turned_field(thicken(tree, 0.3).field, tree, turn)
    np.testing.assert_allclose(follows(everywhere), thicken(moved, 0.3).field(everywhere), atol=1e-9)


@pytest.mark.parametrize("cells", [1, 3, 5])
def test_the_least_wall_of_a_slab(cells):
    slab = from_points([[x, y, z] for x in range(16) for y in range(16) for z in range(cells)], bits=4)
    assert least_wall(slab, 1.0) == cells / 16
    assert least_wall(slab, 1 / 16) == 1 / 16


def test_no_void_is_left_where_contacts_are_joined():
    """Random cells: joining contacts closes drains of one cell, which are bored again."""
    rng = np.random.default_rng(5)
    cells = np.argwhere(rng.random((16, 16, 16)) < 0.6)
    tree = from_points(cells, 4, Cube((0.0,) * 3, 16.0))
    assert voids(join_contacts(tree))
    made = made_printable(tree, Printable(drain=1.0))
    told = made.steps[-1].figures
    assert told["drains"] > 0
    assert len(voids(join_contacts(made.tree))) == told["voids_left"]


def test_steps_follow_the_order_of_the_requests_and_tell_figures():
    rng = np.random.default_rng(1)
    cells = np.argwhere(rng.random((16, 16, 16)) < 0.002)
    tree = from_points(cells, 4, Cube((0.0,) * 3, 16.0))
    shares: list[float] = []
    asked = Printable(wall=2.0, gap=1.0, islands="link", turn="-y", base=2.0, margin=1.0, fit=(40, 40, 40))
    made = made_printable(tree, asked, progress=lambda stage, share: shares.append(share))
    figures = {step.name: step.figures for step in made.steps}
    names = ["walls", "gaps", "islands", "turn", "base", "fit"]
    assert [name for name in figures if name not in ("thin-walls", "tight-gaps")] == names
    assert figures["walls"]["least_before"] == 1.0
    assert figures["islands"]["struts"] == figures["islands"]["found"] - 1 > 0
    assert figures["base"]["height"] == 2.0
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"islands": "burn"}, "one of keep, drop, link"),
        ({"turn": "w"}, "one of keep, fit, x, -x"),
        ({"fit": (1, 2)}, "three sides"),
        ({"strut": 1.0}, "no use"),
        ({"margin": 1.0}, "no use"),
        ({"turn": "fit"}, "build volume"),
    ],
)
def test_requests_are_checked(options, words):
    with pytest.raises(ValueError, match=words):
        Printable(**options)


@pytest.mark.parametrize("name", ["wall", "gap", "strut", "hollow", "base", "drain", "smallest", "margin"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_lengths_out_of_range_are_refused(name, value):
    with pytest.raises(WrongLength) as caught:
        Printable(**{name: value})
    assert caught.value.value == value or np.isnan(value)


def test_nothing_asked_is_nothing_done():
    cube = full(unit_cube(3), bits=2)
    made = made_printable(cube, Printable())
    assert made.tree is cube
    assert made.steps == ()
    assert not Printable().asked
