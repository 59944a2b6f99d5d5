"""The unfolding: the paths of one level, and the pairs among them."""

import re

import pytest

import automata
from automata.topology import embedding
from automata.unfolding import unfolding
from bcifs.__main__ import main
from bcifs.diagram import Box, Words, painted, svg
from bcifs.graph_layout import bundle_words, graph_diagram, layers
from bcifs.paint import width_of
from bcifs.unfold_layout import unfold_diagram
from ifs import shape


@pytest.mark.parametrize("name", automata.builtin_names())
def test_paired_paths_have_the_same_operator(name):
    """A pair is an identity of matrices: the constraint holds for the numbers of the file."""
    automaton = automata.read(name)
    system = shape(automaton).system
    found = unfolding(automaton)
    for pair in found.pairs:
        left = operator(automaton, system, found.cell, pair.left)
        right = operator(automaton, system, found.cell, pair.right)
        end = automaton.end(found.cell, pair.right)
        for label in pair.symmetry:
            right = right[:, list(automaton.cells[end].symmetry[label].points)]
        assert abs(left - right).max() < 1e-12, pair


def operator(automaton, system, cell, path):
    import numpy as np

    result = np.eye(automaton.cells[cell].points)
    for label in path:
        here = automaton.cells[cell]
        if label in here.subdivision:
            state = system.states[cell]
            result = result @ state.operators[state.labels.index(label)]
        else:
            columns = embedding(automaton, cell, (label,))
            matrix = np.zeros((here.points, len(columns)))
            for j, column in enumerate(columns):
                for row, value in column:
                    matrix[row, j] = value
            result = result @ matrix
        cell = automaton.target(cell, label)
    return result


@pytest.mark.parametrize("name", automata.builtin_names())
def test_every_stated_equation_between_two_labels_is_a_pair(name):
    automaton = automata.read(name)
    found = unfolding(automaton)
    meets = {frozenset([pair.left, pair.right]) for pair in found.pairs}
    for equation in automaton.cells[automaton.shape].equations:
        sides = []
        for word in (equation.left, equation.right):
            cell, kept = automaton.shape, []
            for label in word:
                if label not in automaton.cells[cell].symmetry:
                    kept.append(label)
                cell = automaton.target(cell, label)
            sides.append(tuple(kept))
        if all(len(side) == 2 for side in sides):
            assert frozenset(sides) in meets, equation.text


def test_the_pairs_of_the_quadrangular_face():
    found = unfolding(automata.read("doo-sabin-patch"))
    kinds = [pair.kind for pair in found.pairs]
    assert (kinds.count("incidence"), kinds.count("adjacency")) == (8, 4)
    assert {pair.symmetry for pair in found.pairs if pair.kind == "adjacency"} == {("flip",)}
    assert len(found.nodes) == 1 + 4 + 4 + 4 * 2 + 4 * 4
    assert len(found.arrows) == len(found.nodes) - 1


def test_any_cell_can_be_unfolded():
    found = unfolding(automata.read("doo-sabin-patch"), "edge")
    assert [(pair.left, pair.right, pair.symmetry) for pair in found.pairs if pair.kind == "adjacency"] == [
        (("0", "right"), ("1", "left"), ("turn",))
    ]
    with pytest.raises(KeyError):
        unfolding(automata.read("corner-cutting"), "no such cell")


@pytest.mark.parametrize("draw", [graph_diagram, unfold_diagram])
@pytest.mark.parametrize("name", automata.builtin_names())
def test_no_label_lies_on_another_or_outside(name, draw):
    diagram = draw(automata.read(name))
    areas = [extent(part) for part in diagram.parts if isinstance(part, Words)]
    boxes = [part for part in diagram.parts if isinstance(part, Box)]
    for k, (x0, y0, x1, y1) in enumerate(areas):
        assert x0 >= 0
        assert y0 >= 0
        assert x1 <= diagram.width
        assert y1 <= diagram.height
        for u0, v0, u1, v1 in areas[:k]:
            assert x1 <= u0 or u1 <= x0 or y1 <= v0 or v1 <= y0
    for k, box in enumerate(boxes):
        for other in boxes[:k]:
            apart = abs(box.x - other.x), abs(box.y - other.y)
            assert apart[0] >= (box.width + other.width) / 2 or apart[1] >= (box.height + other.height) / 2


def extent(words: Words) -> tuple[float, float, float, float]:
    wide, half = width_of(words.text, words.size), 0.45 * words.size
    left = {"l": words.x, "m": words.x - wide / 2}[words.anchor[0]]
    return left, words.y - half, left + wide, words.y + half


def test_the_rows_of_a_surface_are_face_edge_vertex():
    assert layers(automata.read("catmull-clark-patch")) == [["face"], ["edge"], ["vertex"]]
    assert bundle_words(["left", "right"]) == "left, right"


@pytest.mark.parametrize("options", [[], ["--unfold"]])
def test_pictures_are_written_twice_the_same(tmp_path, capsys, options):
    from PIL import Image

    for ending in ("png", "svg"):
        paths = [tmp_path / f"{k}.{ending}" for k in range(2)]
        for path in paths:
            assert main(["graph", "corner-cutting", "-o", str(path), *options]) == 0
        assert paths[0].read_bytes() == paths[1].read_bytes()
    with Image.open(tmp_path / "0.png") as image:
        assert image.info["bcifs:Name"] == "Corner cutting"
    capsys.readouterr()


def test_svg_says_every_cell_once_a_node():
    automaton = automata.read("corner-cutting")
    text = svg(unfold_diagram(automaton), {})
    assert len(re.findall(r">vertex</text>", text)) == 8
    assert len(re.findall(r">edge</text>", text)) == 3
    picture = painted(graph_diagram(automaton))
    assert len({picture.getpixel((x, 90)) for x in range(0, picture.width, 3)}) > 3


def test_a_wrong_ending_is_refused(capsys):
    assert main(["graph", "corner-cutting", "-o", "graph.pdf"]) == 2
    assert "png" in capsys.readouterr().err
