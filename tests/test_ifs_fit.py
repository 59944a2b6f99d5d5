"""Fits that recover what made the samples, within the error that the noise allows."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline

import ifs
from automata.expression import parse
from ifs.fitting.control import fit_control, fit_curve, project
from ifs.fitting.family import fit_family, operators
from ifs.mixtures.basis import basis
from subdivision.schemes import b_spline, bezier, corner_cutting, de_rham, takagi, tensor

ARCH = np.array([[0.0, 0], [30, 60], [80, 10]])


def samples(shape, t, noise=0.0, seed=0):
    made = basis(shape, t) @ shape.control
    return made + noise * np.random.default_rng(seed).standard_normal(made.shape)


def grid(count):
    return np.linspace(0, 1, count)[:, None]


def test_the_basis_is_bernsteins_and_that_of_the_spline():
    t = grid(17)[:, 0]
    found = basis(ifs.shape(bezier(3)), grid(17))
    expected = np.column_stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    assert np.abs(found - expected).max() < 1e-14
    assert np.abs(basis(ifs.shape(takagi()), grid(65)).sum(axis=1) - 1).max() < 1e-13


def test_exact_samples_give_the_control_points_back():
    for curve in (bezier(4), takagi(), b_spline(3), corner_cutting(0.25, 0.5)):
        true = ifs.shape(curve)
        start = replace(true, control=0 * true.control)
        found = fit_control(start, samples(true, grid(40)), grid(40))
        assert found.ok
        assert found.rank == len(true.control)
        assert np.abs(found.shape.control - true.control).max() < 1e-10


def test_noisy_samples_give_scipys_least_squares_and_honest_deviations():
    true = ifs.shape(bezier(3), control=np.array([[0, 0], [10, 30], [30, -30], [40, 0]]))
    t = grid(200)
    knots = [0, 0, 0, 0, 1, 1, 1, 1]
    errors = []
    for seed in range(40):
        data = samples(true, t, 0.5, seed)
        found = fit_control(true, data, t)
        if seed == 0:
            assert np.allclose(found.shape.control, make_lsq_spline(t[:, 0], data, knots, 3).c, atol=1e-9)
        errors.append((found.shape.control - true.control) / found.deviation[:, None])
        assert found.noise == pytest.approx(0.5, rel=0.2)
    # 320 errors in units of their deviation: their mean square is 1 to within 4 sqrt(2/320).
    assert np.mean(np.square(errors)) == pytest.approx(1, abs=0.32)


def test_a_surface_is_fitted():
    true = ifs.shape(tensor(bezier(2), takagi()))
    u, v = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9))
    t = np.column_stack([u.ravel(), v.ravel()])
    found = fit_control(replace(true, control=0 * true.control), samples(true, t), t)
    assert found.ok
    assert np.abs(found.shape.control - true.control).max() < 1e-10


def test_too_few_samples_are_reported_and_leave_the_rest_where_it_was():
    true = ifs.shape(bezier(3))
    found = fit_control(true, samples(true, grid(2)), grid(2))
    assert (found.ok, found.rank) == (False, 2)
    assert "2 samples determine 2 of 4" in found.why
    assert found.condition == np.inf
    assert np.isinf(found.deviation).all()
    assert np.allclose(found.shape.control, true.control, atol=1e-9)
    held = fit_control(true, samples(true, np.array([[0.3], [0.6]])), np.array([[0.3], [0.6]]), held=[0, 3])
    assert held.ok
    assert np.isnan(held.noise)
    with pytest.raises(ValueError, match="no control point 4 to hold"):
        fit_control(true, samples(true, grid(2)), grid(2), held=[4])
    with pytest.raises(ValueError, match="sample 1 is not finite"):
        fit_control(true, np.array([[0.0, 0], [np.nan, 0]]), grid(2))


def test_projection_finds_the_nearest_point_of_a_parabola():
    curve = ifs.shape(bezier(2), control=np.array([[-1, 1], [0, -1], [1, 1]]))  # y = x^2, x = 2t - 1
    given = np.array([[0.0, 2], [0.3, -0.4], [2, 0]])
    found = project(curve, given)[:, 0] * 2 - 1
    for x, (p, q) in zip(found, given, strict=True):
        roots = np.roots([2, 0, 1 - 2 * q, -p])
        real = np.clip(roots[abs(roots.imag) < 1e-9].real, -1, 1)
        least = min((r - p) ** 2 + (r * r - q) ** 2 for r in [*real, -1, 1])
        assert (x - p) ** 2 + (x * x - q) ** 2 == pytest.approx(least, abs=1e-9)


def test_a_curve_is_fitted_without_parameters():
    true = ifs.shape(bezier(2), control=np.array([[0, 0], [20, 40], [60, 0]]))
    data = samples(true, np.random.default_rng(1).uniform(size=(30, 1)))
    data = np.vstack([data, true.control[[0, 2]]])
    start = replace(true, control=true.control + np.array([[0, 0], [4, 5], [0, 0]]))
    before = data - basis(start, project(start, data)) @ start.control
    few, more = (fit_curve(start, data, held=[0, 2], rounds=rounds) for rounds in (2, 12))
    assert more.rms < few.rms < 0.5 * np.sqrt((before**2).sum(axis=1).mean())
    assert np.abs(more.shape.control - true.control).max() < 0.2 * 5  # a fifth of the error at the start
    assert (few.ok, few.rounds) == (False, 2)
    assert "not settled after 2 rounds" in few.why


def recovered(family, true, t, start, control, expected, noise=0.2):
    """The errors of the parameters in units of their stated deviations."""
    errors = []
    for seed in range(2):
        found = fit_family(family, samples(true, t, noise, seed), t, start, control)
        assert found.ok, found.why
        assert found.noise == pytest.approx(noise, rel=0.35)
        assert found.convergence.verdict == "contracts"
        errors += [(found.values[n] - v) / found.deviation[n] for n, v in expected.items()]
    assert np.abs(errors).max() < 4
    return found


def test_corner_cutting_is_recovered():
    true = ifs.shape(corner_cutting(0.25, 0.5), control=ARCH)
    family = replace(true.automaton, values={})
    found = recovered(family, true, grid(100), {"a": 0.3, "b": 0.3}, ARCH, {"a": 0.25, "b": 0.5})
    assert found.rank == found.unknowns == 2
    assert max(found.deviation.values()) < 0.01


def test_de_rhams_ratio_is_recovered_together_with_the_control_points():
    true = ifs.shape(de_rham(Fraction(1, 3)), control=ARCH)
    family = replace(true.automaton, values={})
    exact = fit_family(family, samples(true, grid(65)), grid(65), {"a": 0.27})
    assert exact.ok, exact.why
    assert exact.values["a"] == pytest.approx(1 / 3, abs=1e-7)
    assert np.abs(exact.shape.control - ARCH).max() < 1e-5
    assert exact.unknowns == 7
    recovered(family, true, grid(65), {"a": 0.27}, None, {"a": 1 / 3})


def takagi_family():
    """Takagi's curve with its ratio left open: its values are expressions in w."""
    values = takagi().values
    entries = {"edge.0[0,1]": "(1 - w)/2", "edge.0[1,1]": "(1 + 2w)/2"}
    return replace(takagi(), values={**values, **{key: parse(text) for key, text in entries.items()}})


def test_takagis_ratio_is_recovered():
    true = ifs.shape(takagi(Fraction(5, 8)), control=ARCH)
    found = recovered(takagi_family(), true, grid(129), {"w": 0.3}, ARCH, {"w": 0.625})
    t = grid(129)[:, 0]
    series = sum(found.values["w"] ** n * np.abs(2**n * t - np.round(2**n * t)) for n in range(60))
    bump = ARCH[1] - (ARCH[0] + ARCH[2]) / 2
    expected = (1 - t)[:, None] * ARCH[0] + t[:, None] * ARCH[2] + 2 * series[:, None] * bump
    assert np.abs(basis(found.shape, grid(129)) @ ARCH - expected).max() < 1e-9


def test_gradients_agree_with_finite_differences():
    import jax

    for family, at in ((replace(corner_cutting(0, 0), values={}), [0.2, 0.3]), (takagi_family(), [0.4])):
        table = operators(family)
        word = [0, 1, 1, 0, 1, 0, 0]

        def column(x, table=table, word=word):
            found = jax.numpy.full(3, 1 / 3)
            for letter in reversed(word):
                found = table.at(x)[letter] @ found
            return found

        with jax.enable_x64(True):
            slope = np.asarray(jax.jacfwd(column)(np.array(at)))
            for k, step in enumerate(1e-5 * np.eye(len(at))):
                change = np.asarray(column(np.array(at) + step) - column(np.array(at) - step)) / 2e-5
                assert np.abs(change - slope[:, k]).max() < 1e-6


def test_samples_that_do_not_determine_the_family_are_reported():
    true = ifs.shape(corner_cutting(0.25, 0.25), control=ARCH)
    family = replace(true.automaton, values={})
    t = np.array([[0.0], [0.4], [1.0]])
    found = fit_family(family, samples(true, t), t, {"a": 0.3, "b": 0.3})
    assert not found.ok
    assert found.rank < found.unknowns == 8
    assert f"3 samples determine {found.rank} of 8" in found.why
    assert found.condition == np.inf
    assert np.isinf(list(found.deviation.values())).all()
    with pytest.raises(ValueError, match=r"the open parameters are \['a', 'b'\]"):
        fit_family(family, samples(true, t), t, {"a": 0.3})
