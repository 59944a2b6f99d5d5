"""Descriptions that cannot hold together are refused where they are wrong."""

from importlib import resources

import pytest

from automata import AutomatonError, builtin_names, parse_text, read
from automata.consistency import require_consistency

DOO_SABIN = (resources.files("automata") / "builtin" / "doo-sabin-patch.toml").read_text()


def without_flip():
    text = DOO_SABIN.replace(' flip"', '"')
    start, end = text.index("[cells.edge.symmetry.flip]"), text.index("[cells.face]")
    return text[:start] + text[end:]


@pytest.mark.parametrize("name", builtin_names())
def test_the_built_in_automata_are_consistent(name):
    require_consistency(read(name))


def fault(text):
    with pytest.raises(AutomatonError) as caught:
        parse_text(text)
    return caught.value


def test_reversed_edges_without_their_symmetry_name_the_one_that_is_missing():
    text = without_flip()
    error = fault(text)
    assert "'0 right = 1 left' glues cell 'edge' the wrong way round" in error.message
    assert "a symmetry of cell 'edge' with points [5, 4, 3, 2, 1, 0]" in error.message
    line = text.split("\n")[error.line - 1]
    assert line[error.column - 1 :].startswith('"0 right = 1 left"')


@pytest.mark.parametrize("label", ["0 right = 1 left", "1 top = 2 bottom", "3 bottom = 0 top"])
def test_a_forgotten_flip_is_found_at_its_equation(label):
    text = DOO_SABIN.replace(f'"{label} flip"', f'"{label}"')
    error = fault(text)
    assert f"{label!r} glues" in error.message
    assert "write the symmetry 'flip'" in error.message


def test_a_corner_seen_in_another_order_needs_a_symmetry():
    error = fault(DOO_SABIN.replace("[2, 5, 8, 1, 4, 7]", "[2, 5, 8, 4, 1, 7]"))
    assert "declare a symmetry of cell 'vertex' with points [0, 1, 3, 2]" in error.message


def test_the_wrong_edge_is_found():
    assert "which they are not" in fault(DOO_SABIN.replace("2 bottom flip", "2 left flip")).message


def test_stated_coherences_are_checked():
    start = DOO_SABIN.index("[cells.face.boundary]")
    head, tail = DOO_SABIN[:start], DOO_SABIN[start:]
    parse_text(head + 'coherence = ["bottom right = right left"]\n' + tail)
    error = fault(head + 'coherence = ["bottom left = right left"]\n' + tail)
    assert "select points [0, 1, 3, 4] and points [2, 5, 1, 4]" in error.message
    assert error.line == head.count("\n") + 1
