"""The command `bcifs fld`: words, data, pictures, and what it refuses."""

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image

import automata
import ifs
from bcifs.behaviours.picture import LEFT_COLOUR, RIGHT_COLOUR, draw_report
from bcifs.behaviours.report import parse_parts, report
from bcifs.behaviours.roughness import colours, draw_roughness, levels_of
from bcifs.behaviours.window import Window, clipped, lines, plane, windows
from bcifs.palette import INK
from bcifs.picture import WrongPicture
from fld import behaviour
from fld.curve import curve
from fld.roughness import roughness

CURVE_KEYS = {
    "kind", "name", "address", "point", "parameter", "critical_order", "ratios", "left", "right", "joint",
    "twin", "local_orders", "holder", "derivatives", "terms",
}  # fmt: skip


def rgb(colour):
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def counted(path, colour):
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))
    return int((pixels == rgb(colour)).all(axis=2).sum())


def test_the_data_of_a_curve_has_the_documented_keys(run):
    for address in ("0", "1 0", "2 (0 1)*", "0 1 3"):
        found = json.loads(run("fld", "koch-curve", address, "--json")[1])
        assert set(found) == CURVE_KEYS
        assert set(found["derivatives"]) == {"left", "right", "passage"}
        assert set(found["terms"]) == set(found["local_orders"]) == {"left", "right"}
        assert found["holder"] == pytest.approx(np.log(3) / np.log(4), abs=1e-12)
    found = json.loads(run("fld", "corner-cutting", "1 0", "--json")[1])
    assert found["twin"] == "0 (1)*"
    assert found["holder"] == "infinite"
    assert found["derivatives"]["right"]["value"] == pytest.approx([30, 0], abs=1e-9)
    assert found["derivatives"]["passage"] == "one derivative of order 1"
    assert [term["order"] for term in found["terms"]["right"]["terms"]] == pytest.approx([1, 2])


def test_the_text_says_all_of_it(run):
    code, out, err = run("fld", "takagi-curve", "1 0")
    assert (code, err) == (0, "")
    said = ("critical order", "Hölder exponent 1", "twin            0 (1)*", "cusp", "infinite at order 1")
    for words in said:
        assert words in out


def test_parametrisation_and_order_change_orders(run):
    arguments = ("fld", "koch-curve", "1 0", "--json")
    found = json.loads(run(*arguments, "--parametrisation", "1/2, 1/6,1/6,1/6", "--order", "0.9")[1])
    assert found["local_orders"]["left"] == pytest.approx(np.log(3) / np.log(6))
    assert found["local_orders"]["right"] == pytest.approx(np.log(3) / np.log(2))
    assert found["derivatives"]["left"]["status"] == "infinite"
    assert found["derivatives"]["right"]["status"] == "zero"
    assert found["parameter"] == pytest.approx(0.5)
    uniform = json.loads(run("fld", "corner-cutting", "0", "--json", "--parametrisation", "uniform")[1])
    assert uniform["ratios"] == {"0": 0.5, "1": 0.5}


def test_parts_are_read_in_the_order_of_the_curve():
    own = curve(ifs.shape("corner-cutting"))
    assert parse_parts(" 1/3 , 2/3", own) == {"0": pytest.approx(1 / 3), "1": pytest.approx(2 / 3)}
    assert parse_parts("natural", own) == "natural"


@pytest.mark.parametrize(
    ("name", "address"),
    [("koch-curve", "1 0"), ("koch-curve", "2 (0 1)*"), ("takagi-curve", "1 0"), ("corner-cutting", "0 1 0")],
)
def test_pictures_show_the_curve_and_both_sides(run, tmp_path, name, address):
    path = tmp_path / "point.png"
    code, out, err = run("fld", name, address, "-o", path)
    assert (code, err) == (0, "")
    assert str(path) in out
    with Image.open(path) as image:
        assert image.size[0] == 1872
        assert "bcifs:Name" in image.info
    assert counted(path, INK) > 3000
    assert counted(path, LEFT_COLOUR) > 300
    assert counted(path, RIGHT_COLOUR) > 300


def test_svg_pictures_are_well_formed_and_the_same_each_time(run, tmp_path):
    paths = [tmp_path / f"{k}.svg" for k in range(2)]
    for path in paths:
        assert run("fld", "koch-curve", "1 0", "-o", path)[0] == 0
    assert paths[0].read_bytes() == paths[1].read_bytes()
    root = ElementTree.parse(paths[0]).getroot()
    texts = [element.text for element in root.iter() if element.tag.endswith("text")]
    assert "Koch curve at 1 (0)*" in texts
    assert sum("times larger" in (text or "") for text in texts) == 2
    fills = {element.get("fill") for element in root.iter()}
    assert {LEFT_COLOUR, RIGHT_COLOUR} <= fills


def test_a_curve_on_a_line_and_one_in_space_have_pictures(run, tmp_path):
    for dim, control in ((1, [[0.0], [2.0], [5.0]]), (3, [[0.0, 0, 0], [4.0, 1, 9], [9.0, 5, 2]])):
        shape = ifs.shape(automata.read("corner-cutting"), control=np.array(control))
        path = tmp_path / f"{dim}.png"
        draw_report(shape, report(shape, "1 0"), path)
        assert counted(path, LEFT_COLOUR) > 300
    with pytest.raises(WrongPicture, match="1 to 3 coordinates"):
        plane(np.zeros((3, 4)))


def test_lines_in_a_deep_window_lie_on_the_parabola():
    """Corner cutting with a = b = 1/4 draws y = 45 - (x - 30)^2 / 15 from (15, 30) to (45, 30)."""
    own = curve(ifs.shape("corner-cutting"))
    centre = np.array([36.0, 45 - 36 / 15])
    for side in (20.0, 1.0, 1e-4):
        found = lines(own, own.control, Window(centre, side), side / 300)
        assert len(found) == 1
        x, y = (found[0] - centre).T
        # y - y_0 = -(2 (x_0 - 30) (x - x_0) + (x - x_0)^2) / 15
        assert np.abs(y + (12 * x + x**2) / 15).max() < 1e-12 * 60 + 1e-9 * side
        assert x[0] <= max(-side / 2 * 0.6, -21 + 1e-9)
        assert np.linalg.norm(np.diff(found[0], axis=0), axis=1).max() < side / 100


def test_zooms_are_powers_of_the_dominant_eigenvalue():
    shape = ifs.shape("koch-curve")
    own = curve(shape)
    at = behaviour(shape, "1 0")
    whole, first, second = windows(own, own.control, at.point, (at.left, at.right), ("1",))
    assert first.side / second.side == pytest.approx(9)
    assert first.side <= whole.side / 4
    assert whole.side == pytest.approx(1.12 * 90)


def test_clipping_keeps_what_is_inside():
    zigzag = np.array([[-1.0, 0.5], [0.5, 0.5], [0.5, 2.0], [0.8, 2.0], [0.8, 0.2]])
    found = clipped(zigzag, np.zeros(2), np.ones(2))
    assert [part.tolist() for part in found] == [
        [[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]],
        [[0.8, 1.0], [0.8, pytest.approx(0.2)]],
    ]
    assert clipped(zigzag + 10, np.zeros(2), np.ones(2)) == []


def test_an_address_of_a_patch_says_which_corner_it_is(run):
    assert "at @ 0: corner 0 of the whole" in run("fld", "catmull-clark-patch", "0")[1]
    assert "at 0 @ 2: corner 2 of the piece 0" in run("fld", "catmull-clark-patch", "0 @ 2")[1]


def test_points_have_no_rounding_beside_the_size_of_the_curve(run):
    for name, x in (("koch-curve", 90), ("takagi-curve", 80)):
        point = json.loads(run("fld", name, "3" if x == 90 else "1", "--json")[1])["point"]
        assert point[0] == pytest.approx(x)
        assert point[1] == 0.0
    at = json.loads(run("fld", "koch-curve", "1 2", "--json")[1])["point"]
    assert at[1] != 0.0


def test_a_vertex_of_a_patch(run):
    found = json.loads(run("fld", "catmull-clark-patch", "0 @ 2", "--json")[1])
    assert set(found) == {"kind", "name", "address", "point", "joint", "normal", "turn", "corners", "words"}
    assert (found["kind"], found["joint"], len(found["corners"])) == ("patch", "smooth", 4)
    other = json.loads(run("fld", "catmull-clark-patch", "2 (0)*", "--json")[1])
    assert other["point"] == pytest.approx(found["point"], abs=1e-9)
    assert other["normal"] == pytest.approx(found["normal"], abs=1e-9)
    assert "3 directions shrink alike" in run("fld", "fractal-patch", "0 @ 2")[1]


def test_a_point_of_a_product_of_curves(run):
    arguments = ("fld", "takagi-curve", "1 0, 1 0", "--times", "corner-cutting")
    found = json.loads(run(*arguments, "--json")[1])
    assert (found["kind"], found["joint"], len(found["quarters"])) == ("product", "fold along v", 4)
    assert set(found["sections"]["u"]) == {"left", "right"}
    code, out, err = run(*arguments)
    assert (code, err) == (0, "")
    assert "fold along v" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("koch-curve", "7"), "unknown label '7'"),
        (("koch-curve", ""), "must repeat one label"),
        (("koch-curve", "0 (1"), "parentheses"),
        (("koch-curve", "0", "-o", "/nowhere/x.png"), "there is no folder"),
        (("koch-curve", "0", "-o", "x.pdf"), "ends in .png or .svg"),
        (("koch-curve", "0", "--parametrisation", "1,2"), "4 parts of sum 1"),
        (("koch-curve", "0", "--parametrisation", "1,1,1,1"), "between 0 and 1"),
        (("koch-curve", "0", "--parametrisation", "a,b,c,d"), "found the name 'a'"),
        (
            ("corner-cutting", "0", "--parametrisation", "1/0,1/2"),
            "'1/0', the part of piece '0': division by",
        ),
        (
            ("corner-cutting", "0", "--parametrisation", "1/2,3/2"),
            "'3/2', the part of piece '1': it is not be",
        ),
        (("koch-curve", "0", "--order", "0"), "above 0 and finite"),
        (("menger-sponge", "0"), "no self-similar curve"),
        (("sierpinski-triangle", "0"), "no self-similar curve"),
        (("nonuniform-quadratic-spline", "0"), "sub-cell '0' is a 'uvv'"),
        (("catmull-clark-patch", "7"), "unknown label '7'"),
        (("catmull-clark-patch", "7"), "a patch is looked at in a corner of a piece: '0' or '1 (2)*' is"),
        (("catmull-clark-patch", ""), "'1 2 @ 3' is corner 3 of the piece 1 2"),
        (("catmull-clark-patch", "0 @ 7"), "a number from 0 to 3"),
        (("catmull-clark-patch", "(0 3)*"), "is no corner of a piece"),
        (("catmull-clark-patch", "0 1 2 3 0 1 @ 0"), "6 subdivisions deep"),
        (("catmull-clark-patch", "0", "-o", "x.png"), "--output is for curves"),
        (("catmull-clark-patch", "0", "--order", "1"), "--order is for curves"),
        (("takagi-curve", "0", "--times", "corner-cutting"), "with a comma"),
        (("takagi-curve", "0, 9", "--times", "corner-cutting"), "unknown label '9'"),
        (("takagi-curve", "0, 0", "--times", "menger-sponge"), ""),
    ],
)
def test_wrong_input_gives_one_line(run, arguments, message):
    code, out, err = run("fld", *arguments)
    assert (code, out) == (2, "")
    assert err.startswith("bcifs: ")
    assert err.count("\n") == 1
    assert message in err


def written(folder, cells, control):
    path = folder / "made.toml"
    path.write_text(
        f'format = "bcifs/1"\nname = "Made"\nshape = "edge"\n[cells.vertex]\npoints = 1\n'
        f'subdivision = {{ s = "vertex" }}\n[cells.edge]\npoints = 2\nsubdivision = {cells}\n'
        f'boundary = {{ left = {{ cell = "vertex", points = [0] }}, '
        f'right = {{ cell = "vertex", points = [1] }} }}\n'
        f'incidence = ["left s = 0 left", "right s = 1 right"]\nadjacency = ["0 right = 1 left"]\n'
        f'[set]\n"edge.0[0,1]" = "1/2"\n[control]\npoints = {control}\n'
    )
    return path


def test_a_curve_of_two_points_and_one_that_is_a_point(run, tmp_path):
    cells = '{ 0 = "edge", 1 = "edge" }'
    code, out, _ = run("fld", written(tmp_path, cells, "[[0, 0], [9, 9]]"), "1 0", "-o", tmp_path / "a.png")
    assert code == 0
    assert "smooth passage" in out
    code, out, err = run("fld", written(tmp_path, cells, "[[4, 4], [4, 4]]"), "0", "-o", tmp_path / "b.png")
    assert (code, out) == (2, "")
    assert "single point" in err
    assert not (tmp_path / "b.png").exists()


def test_roughness_maps_are_coloured_by_order(tmp_path):
    shape = ifs.shape("corner-cutting", {"a": "1/5", "b": "1/2"})
    found = roughness(shape, 3, detail=4)
    levels = levels_of(found)
    assert levels[found.orders.argmin()] == 0
    assert levels[found.orders.argmax()] == len(colours()) - 2
    assert (np.diff(levels[np.argsort(found.orders)]) >= 0).all()
    draw_roughness(found, tmp_path / "map.png")
    assert counted(tmp_path / "map.png", colours()[0]) > 300
    draw_roughness(found, tmp_path / "map.svg")
    ElementTree.parse(tmp_path / "map.svg")
    patch = roughness(ifs.shape("fractal-patch"), 2, detail=1)
    draw_roughness(patch, tmp_path / "patch.png")
    with Image.open(tmp_path / "patch.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 100
    with pytest.raises(WrongPicture, match="draw curves as"):
        draw_roughness(patch, tmp_path / "patch.svg")
