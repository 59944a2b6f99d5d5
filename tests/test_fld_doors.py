"""Wrong kinds of values at the doors of `ifs` and `fld`, and control points out of the range of doubles.

The wrong kinds are tried in a process of its own: in this one the types of all arguments are checked before
the functions themselves see them.
"""

import json
import subprocess
import sys

import numpy as np
import pytest

import fld
import ifs
from fld.error import OutOfScale
from fld.scale import settled
from fld.surfaces import patches
from fld.wording import written
from subdivision.schemes import bezier

CALLS = {
    "fld.derivatives(k, 0)": ("TypeError", "an address is a text such as '0'"),
    "fld.behaviour(k, None)": ("TypeError", "found None"),
    "fld.behaviour('koch-curve', '0')": ("TypeError", 'make one by ifs.shape("koch-curve")'),
    "fld.critical_order(3)": ("TypeError", "expected a shape, found 3 (int)"),
    "fld.watch(k, '0123', steps=1.5)": (
        "ValueError",
        "steps is a whole number, 1 to 100000, found 1.5",
    ),
    "fld.watch(k, 0)": ("TypeError", "labels are a word"),
    "fld.roughness(k, 1.5)": ("ValueError", "depth is a whole number, 1 or more, found 1.5"),
    "fld.roughness(k, 1, detail='2')": ("ValueError", "detail is a whole number, 0 or more, found '2'"),
    "fld.roughness(3)": ("TypeError", "expected a shape, found 3 (int)"),
    "fld.classify(k, np.zeros((1, 2)))": ("TypeError", "expected a family"),
    "fld.fit_behaviour(3, order=1.0)": ("TypeError", "found 3 (int)"),
    "fld.fit_behaviour('koch-curve', order=1.0, starts=1.5)": (
        "ValueError",
        "starts is a whole number, 1 or more",
    ),
    "ifs.mesh(k, 2.5)": ("ValueError", "depth is a whole number, 0 to 64, found 2.5"),
    "ifs.mesh('koch-curve', 2)": ("TypeError", "found 'koch-curve' (str)"),
    "ifs.shape(3)": ("TypeError", "a built-in name such as 'koch-curve'; found 3 (int)"),
    "ifs.bounding_box(None)": ("TypeError", "expected a shape, found None (NoneType)"),
    "points(k, -1, 0)": ("ValueError", "count of points is a whole number, 0 or more, found -1"),
    "points(k, 1.5, 0)": ("ValueError", "count of points is a whole number, 0 or more, found 1.5"),
    "points(k, 1, 'x')": ("ValueError", "seed is a whole number"),
    "length(k, 4.0)": ("ValueError", "depth is a whole number, 3 or more, found 4.0"),
}

SCRIPT = """
import json, sys
import numpy as np
import fld, ifs
from ifs.measures.length import length
from ifs.orbits.chaos import points
k = ifs.shape("koch-curve")
found = []
for call in json.load(sys.stdin):
    try:
        found.append(["nothing", repr(eval(call))])
    except Exception as error:
        found.append([type(error).__name__, str(error)])
print(json.dumps(found))
"""


def test_wrong_kinds_are_named():
    ran = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        input=json.dumps(list(CALLS)),
        capture_output=True,
        text=True,
        check=True,
    )
    for (call, (kind, words)), (found, said) in zip(CALLS.items(), json.loads(ran.stdout), strict=True):
        assert (call, found) == (call, kind), said
        assert words in said, call


@pytest.mark.parametrize("size", [1e-90, 1e-20, 1e20, 1e90])
def test_orders_and_directions_do_not_depend_on_the_unit(size):
    control = np.array([[0, 0], [1, 2], [3, 1], [4, 0.0]])
    plain, large = (fld.behaviour(ifs.shape(bezier(3), control=f * control), "1 0") for f in (1.0, size))
    assert large.right is not None
    assert plain.right is not None
    assert large.right.order == pytest.approx(plain.right.order, abs=1e-12)
    assert large.right.direction == pytest.approx(plain.right.direction, abs=1e-12)
    assert large.right.size == pytest.approx(size * plain.right.size, rel=1e-9)
    assert large.point == pytest.approx(size * plain.point, rel=1e-12)


@pytest.mark.parametrize("size", [1e-200, 1e101, 1e200, 1e308])
def test_sizes_that_cannot_be_squared_are_refused_by_their_name(size):
    control = np.array([[0, 0], [1, 2], [3, 1], [4, 0.0]]) / 4
    with pytest.raises(OutOfScale, match="in another unit") as caught:
        fld.behaviour(ifs.shape(bezier(3), control=size * control), "1 0")
    assert caught.value.size == pytest.approx(size)
    patch = ifs.shape("doo-sabin-patch")
    with pytest.raises(OutOfScale):
        patches(ifs.shape(patch.automaton, control=patch.control / np.abs(patch.control).max() * size))


def test_a_curve_of_one_point_is_no_matter_of_scale():
    with pytest.raises(fld.Collapsed, match="move its control points apart"):
        fld.critical_order(ifs.shape(bezier(3), control=np.ones((4, 2))))


def test_zeros_are_zeros_at_any_scale():
    control = np.array([[1.0, 0.0], [90.0, -90.0]])
    for size in (1e-30, 1.0, 1e30):
        assert settled(size * np.array([90, 5e-14]), size * control).tolist() == [size * 90, 0.0]
        assert settled(size * np.array([90, 5e-11]), size * control)[1] == size * 5e-11
    assert written(np.array([1e-30, -1e-45, 2e-30])) == "(1e-30, 0, 2e-30)"
