"""Small automata made at random: the solver against dense elimination over the fractions."""

from fractions import Fraction
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from automata import describe
from subdivision import Contradiction, solve


@st.composite
def descriptions(draw):
    """A curve of two or three pieces: random sizes, random ends, random equations that compose."""
    small = draw(st.integers(1, 2))
    large = draw(st.integers(small, 4))
    labels = [str(i) for i in range(draw(st.integers(2, 3)))]

    def end():
        points = draw(st.permutations(range(large)))[:small]
        return {"cell": "vertex", "points": list(points)}

    sides = [f"{label} {b}" for label in labels for b in ("left", "right")]
    inner = [*sides, "left s", "right s"]
    equations = draw(st.lists(st.tuples(st.sampled_from(inner), st.sampled_from(inner)), max_size=4))
    edge = {
        "points": large,
        "subdivision": dict.fromkeys(labels, "edge"),
        "boundary": {"left": end(), "right": end()},
        "adjacency": [" = ".join(pair) for pair in equations],
    }
    if draw(st.booleans()):
        open_ = st.sampled_from(["*", "*", "*", 0, 1, "1/2", "-1/3"])
        rows = [[draw(open_) for _ in range(large)] for _ in range(large)]
        rows[draw(st.integers(0, large - 1))] = ["*"] * large
        edge["matrices"] = {"0": rows}
    cells = {"vertex": {"points": small, "subdivision": {"s": "vertex"}}, "edge": edge}
    return {"format": "bcifs/1", "shape": "edge", "cells": cells}


def equations_of(document):
    """The augmented rows over all entries of all operators, written out entry by entry."""
    vertex, edge = document["cells"]["vertex"], document["cells"]["edge"]
    size = {"vertex": vertex["points"], "edge": edge["points"]}
    names = [("vertex", "s", i, j) for i, j in product(range(size["vertex"]), repeat=2)]
    for label in edge["subdivision"]:
        names += [("edge", label, i, j) for i, j in product(range(size["edge"]), repeat=2)]
    column = {name: k for k, name in enumerate(names)}
    rows = []

    def entry(word, i, j):
        """The places that sum to entry (i, j) of `0 left` or `left s`; a boundary selects points."""
        first, second = word.split()
        if first in edge["boundary"]:
            points = edge["boundary"][first]["points"]
            return [column["vertex", second, points.index(i), j]] if i in points else []
        return [column["edge", first, i, edge["boundary"][second]["points"][j]]]

    for text in edge["adjacency"]:
        left, right = text.split(" = ")
        for i, j in product(range(size["edge"]), range(size["vertex"])):
            row = [Fraction(0)] * (len(names) + 1)
            for place in entry(left, i, j):
                row[place] += 1
            for place in entry(right, i, j):
                row[place] -= 1
            rows.append(row)
    for label, given_rows in edge.get("matrices", {}).items():
        for i, line in enumerate(given_rows):
            for j, value in enumerate(line):
                if value != "*":
                    row = [Fraction(0)] * (len(names) + 1)
                    row[column["edge", label, i, j]], row[-1] = Fraction(1), Fraction(value)
                    rows.append(row)
    for cell, label in (("vertex", "s"), *(("edge", label) for label in edge["subdivision"])):
        for j in range(size[cell]):
            row = [Fraction(0)] * (len(names) + 1)
            for i in range(size[cell]):
                row[column[cell, label, i, j]] = Fraction(1)
            rows.append([*row[:-1], Fraction(1)])
    return names, rows


def rank_and_consistency(rows, unknowns):
    rank = 0
    for column in range(unknowns):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        lead = [x / rows[rank][column] for x in rows[rank]]
        rows[rank] = lead
        for i in range(rank + 1, len(rows)):
            factor = rows[i][column]
            if factor:
                rows[i] = [x - factor * y for x, y in zip(rows[i], lead, strict=True)]
        rank += 1
    return rank, not any(row[-1] for row in rows[rank:])


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(descriptions(), st.data())
def test_random_automata(document, data):
    names, rows = equations_of(document)
    rank, consistent = rank_and_consistency([list(row) for row in rows], len(names))
    automaton = describe(document)
    if not consistent:
        with pytest.raises(Contradiction) as caught:
            solve(automaton)
        assert len(caught.value.equations) >= 2
        return
    family = solve(automaton)
    assert family.degrees_of_freedom == len(names) - rank
    drawn = st.fractions(-2, 2, max_denominator=5)
    values = {parameter.name: data.draw(drawn) for parameter in family.parameters}
    numbers = family.with_values(values).numbers()
    point = [numbers[cell][label][i][j] for cell, label, i, j in names]
    for row in rows:
        assert sum(x * y for x, y in zip(row, point, strict=False)) == row[-1]
