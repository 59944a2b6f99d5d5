"""Linear systems over the fractions, against dense elimination."""

from fractions import Fraction
from itertools import chain, combinations

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from subdivision.elimination import Inconsistent, LinearSystem, minimal_conflict
from subdivision.form import CONSTANT, add, constant

SIZE = 7


def dense(forms, size):
    """Gauss-Jordan on the augmented matrix: its rank, and whether the equations have a solution."""
    rows = [[Fraction(form.get(k, 0)) for k in (*range(size), CONSTANT)] for form in forms]
    rank = 0
    for column in range(size):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        rows[rank] = [entry / rows[rank][column] for entry in rows[rank]]
        for i, row in enumerate(rows):
            if i != rank and row[column]:
                rows[i] = [x - row[column] * y for x, y in zip(row, rows[rank], strict=True)]
        rank += 1
    return rank, all(not row[-1] for row in rows[rank:])


def cleaned(form):
    return {key: Fraction(value) for key, value in form.items() if value}


SMALL = st.integers(-2, 2).map(Fraction)
SPARSE = st.dictionaries(st.integers(-1, SIZE - 1), SMALL, max_size=4).map(cleaned)
EQUAL = st.tuples(st.integers(0, SIZE - 1), st.integers(0, SIZE - 1)).map(
    lambda pair: cleaned({pair[0]: 1, pair[1]: -1}) if pair[0] != pair[1] else {}
)
SYSTEMS = st.lists(SPARSE | EQUAL, max_size=9)
ORDERS = st.permutations(range(SIZE))


def solved(forms, order):
    system = LinearSystem(SIZE, lambda i: (order[i],))
    system.require(forms)
    return system


@settings(max_examples=100)
@given(SYSTEMS, ORDERS)
def test_consistency_and_rank_are_those_of_dense_elimination(forms, order):
    rank, consistent = dense(forms, SIZE)
    if not consistent:
        with pytest.raises(Inconsistent) as caught:
            solved(forms, order)
        assert caught.value.residual != 0
        return
    system = solved(forms, order)
    assert len(system.free(range(SIZE))) == SIZE - rank
    assert all(system.reduce(form) == {} for form in forms)


@settings(max_examples=60)
@given(SYSTEMS, ORDERS, st.lists(SMALL, min_size=SIZE, max_size=SIZE))
def test_every_choice_of_the_free_unknowns_is_a_solution(forms, order, choice):
    assume(dense(forms, SIZE)[1])
    system = solved(forms, order)
    free = system.free(range(SIZE))

    def at(form):
        return sum((c * (1 if k == CONSTANT else choice[k]) for k, c in form.items()), Fraction(0))

    numbers = [at(system.value(i)) for i in range(SIZE)]
    assert all(numbers[i] == choice[i] for i in free)
    for form in forms:
        assert sum(c * (1 if k == CONSTANT else numbers[k]) for k, c in form.items()) == 0


@given(SYSTEMS, SYSTEMS, ORDERS)
def test_equations_may_come_in_any_portions(first, second, order):
    assume(dense(first + second, SIZE)[1])
    whole, parts = solved(first + second, order), solved(first, order)
    parts.require(second)
    rank = dense(first + second, SIZE)[0]
    assert len(parts.free(range(SIZE))) == len(whole.free(range(SIZE))) == SIZE - rank
    assert all(parts.reduce(form) == {} for form in first + second)


@settings(max_examples=60)
@given(SYSTEMS, st.lists(st.integers(-3, 3), min_size=9, max_size=9))
def test_an_implied_equation_changes_nothing(forms, weights):
    assume(dense(forms, SIZE)[1])
    implied = {}
    for form, weight in zip(forms, weights, strict=False):
        implied = add(implied, form, Fraction(weight))
    system = solved(forms, range(SIZE))
    before = [system.value(i) for i in range(SIZE)]
    system.require([implied])
    assert [system.value(i) for i in range(SIZE)] == before


GROUPS = st.lists(st.lists(SPARSE | EQUAL, min_size=1, max_size=2), min_size=3, max_size=8)
IMPOSSIBLE = GROUPS.filter(lambda groups: not dense(list(chain(*groups)), SIZE)[1])


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow]
)
@given(IMPOSSIBLE)
def test_a_conflict_is_one_and_loses_it_without_any_of_its_members(groups):
    def consistent(chosen):
        return dense([form for i in chosen for form in groups[i]], SIZE)[1]

    conflict, residual = minimal_conflict(groups, SIZE)
    assert residual != 0
    assert conflict == sorted(set(conflict))
    assert not consistent(conflict)
    assert all(consistent(rest) for rest in combinations(conflict, len(conflict) - 1))


def test_the_pivot_is_the_unknown_of_highest_priority():
    system = LinearSystem(3, lambda i: (i == 1, i))
    system.require([{0: Fraction(2), 1: Fraction(4), 2: Fraction(1), CONSTANT: Fraction(-8)}])
    assert system.free(range(3)) == [0, 2]
    assert system.value(1) == {0: Fraction(-1, 2), 2: Fraction(-1, 4), CONSTANT: Fraction(2)}


def test_a_sum_of_one_unknown_with_itself_is_twice_it():
    system = LinearSystem(2)
    system.require(
        [{0: Fraction(1), 1: Fraction(-1)}, {0: Fraction(1), 1: Fraction(1), CONSTANT: Fraction(-1)}]
    )
    assert system.value(1) == constant(Fraction(1, 2))
