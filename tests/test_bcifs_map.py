"""The command `bcifs map`: pictures, data, text."""

import json

import numpy as np
import pytest
from PIL import Image

from bcifs.__main__ import main
from bcifs.chart import COLOURS, LEFT, SIDE, TOP, draw_map, ticks
from bcifs.samples import middles, sample
from fld.classes import named
from fld.regions import regions

MAP = regions("corner-cutting", "a", "b", resolution=80)


def pixel(picture, a, b):
    return picture.getpixel((round(LEFT + SIDE * (a + 1) / 2), round(TOP + SIDE * (1 - b) / 2)))


def rgb(colour):
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def test_each_region_has_its_colour_where_it_lies():
    picture = draw_map(MAP, "Corner cutting")
    inside = {1: (0.1, 0.15), 2: (-0.3, 0.5), 3: (0.08, 0.7), 4: (0.45, 0.5), 5: (0.8, 0.5)}
    for number, place in inside.items():
        assert pixel(picture, *place) == rgb(COLOURS[number - 1])
    mirrored = pixel(picture, 0.5, -0.3)
    assert mirrored not in {rgb(colour) for colour in COLOURS}
    assert mirrored != pixel(picture, -0.5, -0.5)


def test_the_map_is_its_own_mirror_image():
    numbers = np.zeros(len(MAP.facts.verdict), int)
    for region in named(MAP):
        numbers[region.members | region.mirrored] = region.number
    grid = MAP.grid(numbers)
    assert (grid == grid.T).all()


def test_samples_lie_in_their_regions_and_are_curves():
    for region in named(MAP)[:5]:
        made = sample(MAP, region)
        column, row = np.abs(MAP.x - made.place[0]).argmin(), np.abs(MAP.y - made.place[1]).argmin()
        assert MAP.grid(region.members)[row, column]
        steps = np.linalg.norm(np.diff(made.points, axis=0), axis=1)
        assert steps.max() < 0.1 * np.ptp(made.points, axis=0).max()
    chaikin = sample(
        regions("corner-cutting", "a", "b", x_range=(0.2, 0.3), y_range=(0.2, 0.3), resolution=1),
        named(regions("corner-cutting", "a", "b", x_range=(0.2, 0.3), y_range=(0.2, 0.3), resolution=1))[0],
    )
    x, y = chaikin.points.T
    assert np.abs(y - (30 - (x - 30) ** 2 / 15 + 15)).max() < 1e-9


def test_innermost_places_are_one_a_part():
    mask = np.zeros((80, 80), bool)
    mask[10:31, 20:41] = mask[50:61, 60:71] = True
    assert [tuple(place) for place in middles(MAP, mask.ravel())] == [
        (MAP.x[30], MAP.y[20]),
        (MAP.x[65], MAP.y[55]),
    ]


def test_the_command_writes_a_picture_with_its_recipe(tmp_path, capsys):
    paths = [tmp_path / f"{k}.png" for k in range(2)]
    arguments = ["map", "corner-cutting", "--x", "a", "--y", "b", "--resolution", "40"]
    for path in paths:
        assert main([*arguments, "-o", str(path), "--range-x", "-0.5", "1"]) == 0
    out, err = capsys.readouterr()
    assert "region 1" in out
    assert err == ""
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with Image.open(paths[0]) as image:
        assert image.info["bcifs:Map"] == "a from -0.5 to 1, b from -1 to 1, 40 fields a side"


def test_the_data_of_a_map(capsys):
    assert main(["map", "corner-cutting", "--x", "a", "--y", "b", "--resolution", "200", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert sum(found["shares"].values()) == pytest.approx(1)
    assert found["here"] == pytest.approx([0.25, 0.25])
    regions_ = {region["number"]: region for region in found["regions"]}
    # Areas of the triangles and the quadrilateral, as shares of the square of area 4.
    assert regions_[1]["share"] == pytest.approx(1 / 24, abs=0.003)
    assert regions_[4]["share"] == pytest.approx(1 / 24, abs=0.004)
    assert regions_[5]["share"] == pytest.approx(1 / 8, abs=0.004)
    assert regions_[2]["share"] == regions_[2]["mirrored_share"] > 0.04
    # |a|, |b|, |1 - a - b| < 1 leaves a hexagon of area 2 of the square.
    assert found["contracts_alone"] == pytest.approx(1 / 2, abs=0.01)


def test_wrong_input_is_refused(capsys):
    for arguments in (
        ["--x", "a", "--y", "c", "--json"],
        ["--x", "a", "--y", "b", "-o", "map.svg"],
        ["--x", "a", "--y", "b"],
        ["--x", "a", "--y", "b", "--range-x", "1", "0", "--json"],
    ):
        assert main(["map", "corner-cutting", *arguments]) == 2
        assert capsys.readouterr().err


def test_ticks_are_round_and_inside():
    for low, high in ((-1, 1), (0, 0.013), (-250, 1000)):
        found = ticks(low, high)
        assert low <= found[0] < found[-1] <= high
        assert 4 <= len(found) <= 10


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--x", "a", "--y", "a"), "a twice makes no plane"),
        (("--x", "a", "--y", "edge.0[1,0]"), "cannot be chosen independently"),
        (("--x", "a", "--y", "edge.0[0,0]"), "cannot be chosen independently"),  # 1 - a
        (("--x", "a", "--y", "b", "--set", "a=1/4"), "a varies over the map"),
    ],
)
def test_two_names_that_span_no_plane_are_refused(capsys, arguments, message):
    assert main(["map", "corner-cutting", *arguments, "--resolution", "2", "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
