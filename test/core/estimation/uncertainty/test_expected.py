"""Expected errors of GRF and CoP against shoes and supports drawn at random."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.error_sources.altered import body_states
from core.estimation.drawn import TOLERANCES, Drawn
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.body import closure, driven_together
from shoecal_core.estimation.uncertainty.expected import ErrorModel, Spread, support_covariance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.wrench import ChannelParameters, combined, cop, foot_wrenches

SMALL = 0.05
"""Of the covariance's root: within it measured GRF and CoP are linear."""
DRAWS = 1500
WITHIN = 0.1
"""Of a standard deviation from so many draws, five times its own."""


@pytest.fixture(scope="module")
def model(known: Drawn) -> ErrorModel:
    """Of channels and shoe alone: the weight, the support and sideways forces are exact."""
    fit = known.fit
    robot = replace(fit.signal_model.samples.robot, mass_std=0.0)
    exact = replace(TOLERANCES, sideways_share=0.0)
    return ErrorModel.of(
        robot, fit.shoe, fit.signal_model.samples.shoe, fit.parameters, *fit.measuring,
        np.zeros((3, 3)), exact,
    )  # fmt: skip


def loads(model: ErrorModel, which: int) -> FloatArray:
    """(p, n) a few of the load cases of both feet, left or right."""
    return model.load_cases()[which][::7]


def by_draws(model: ErrorModel, outputs: FloatArray, which: int) -> tuple[FloatArray, FloatArray]:
    """(p,) and (p, 2) spread of measured GRF and CoP over channels and columns that are drawn."""
    rng = np.random.default_rng(3)
    readings = (outputs - model.parameters.offset) / model.parameters.gain
    values, vectors = np.linalg.eigh(model.covariance)
    root = SMALL * vectors * np.sqrt(np.clip(values, 0.0, None))
    count = len(model.shoe.names)
    grf, places = [], []
    for _ in range(DRAWS):
        off = root @ rng.standard_normal(len(root))
        law = ChannelParameters(
            model.parameters.gain + off[:count], model.parameters.offset + off[count : 2 * count]
        )
        columns = model.shoe.columns + np.tensordot(off[2 * count :], model.shoe_columns, 1)
        feet = foot_wrenches(model.shoe.with_columns(columns), law.outputs(readings))
        wrench = combined(feet, model.robot.neutral) if which == 0 else feet[:, which - 1]
        grf.append(wrench[:, 0])
        places.append(cop(wrench, 1.0))
    return np.std(grf, axis=0) / SMALL, np.std(places, axis=0) / SMALL


def spread(model: ErrorModel, outputs: FloatArray, which: int) -> Spread:
    if which == 0:
        return model.both_feet(outputs, model.robot.neutral)
    return model.foot(outputs, which - 1)


@pytest.mark.parametrize("which", range(3))
def test_channels_and_shoe_spread_grf_and_cop_as_foretold(model: ErrorModel, which: int) -> None:
    outputs = loads(model, which)
    assert len(outputs) > 3
    grf, places = by_draws(model, outputs, which)
    found = spread(model, outputs, which)
    np.testing.assert_allclose(found.grf, grf, rtol=WITHIN)
    np.testing.assert_allclose(found.cop, places, rtol=WITHIN)
    feet = foot_wrenches(model.shoe, outputs)
    wrench = combined(feet, model.robot.neutral) if which == 0 else feet[:, which - 1]
    np.testing.assert_allclose(found.places, cop(wrench, 1.0))


def test_where_the_right_foot_stands_moves_the_cop_of_both_feet(model: ErrorModel) -> None:
    """Against supports drawn at random; single feet do not ask where the other one stands."""
    rng = np.random.default_rng(4)
    root = np.array([[2e-4, 0.0, 0.0], [1e-4, 2e-4, 0.0], [1e-3, -1e-3, 2e-3]])
    placed = replace(model, support_covariance=root @ root.T)
    outputs, place = loads(model, 0), model.robot.neutral
    feet = foot_wrenches(model.shoe, outputs)
    found = []
    for _ in range(DRAWS):
        dx, dy, turn = root @ rng.standard_normal(3)
        stands = DoubleSupport(place.dx + dx, place.dy + dy, place.dtheta + turn)
        found.append(cop(combined(feet, stands), 1.0))
    more = placed.both_feet(outputs, place).cop ** 2 - model.both_feet(outputs, place).cop ** 2
    np.testing.assert_allclose(np.sqrt(more), np.std(found, axis=0), rtol=WITHIN)
    one = loads(model, 1)
    np.testing.assert_array_equal(placed.foot(one, 0).cop, model.foot(one, 0).cop)


def test_sideways_forces_move_each_foot_and_not_both(model: ErrorModel) -> None:
    """By hand: a force S at half the shoe's height h turns the sole by S h / 2."""
    sideways = 2.0
    pushed = replace(model, sideways=sideways)
    for foot in (0, 1):
        outputs = loads(model, 1 + foot)
        force = foot_wrenches(model.shoe, outputs)[:, foot, 0]
        more = pushed.foot(outputs, foot).cop ** 2 - model.foot(outputs, foot).cop ** 2
        moved = sideways * 0.5 * model.shoe.height / force
        np.testing.assert_allclose(np.sqrt(more), np.stack((moved, moved), axis=1), rtol=1e-6)
    outputs = loads(model, 0)
    np.testing.assert_array_equal(
        pushed.both_feet(outputs, model.robot.neutral).cop,
        model.both_feet(outputs, model.robot.neutral).cop,
    )


def test_a_weight_that_is_off_scales_the_grf_alone(model: ErrorModel) -> None:
    mass_std = 0.01 * model.robot.mass
    weighed = replace(model, robot=replace(model.robot, mass_std=mass_std))
    outputs = loads(model, 0)
    before, after = (one.both_feet(outputs, model.robot.neutral) for one in (model, weighed))
    more = np.sqrt(after.grf**2 - before.grf**2)
    np.testing.assert_allclose(more, 0.01 * model.robot.weight, rtol=1e-3)
    np.testing.assert_allclose(after.cop, before.cop, rtol=1e-12)


def test_a_foot_without_load_has_no_cop(model: ErrorModel) -> None:
    found = model.foot(np.zeros((1, len(model.shoe.names))), 0)
    assert np.isnan(found.cop).all()
    assert np.isnan(found.places).all()
    assert np.isfinite(found.grf).all()


def test_the_support_is_as_sure_as_its_tolerance_and_the_joints(known: Drawn) -> None:
    """One motor's zero that is off moves the right sole as Pinocchio says: by what was found of
    it, and by what is still uncertain of it.
    """
    fit = known.fit
    own = np.diag([TOLERANCES.support_m, TOLERANCES.support_m, TOLERANCES.support_rad]) ** 2
    np.testing.assert_allclose(support_covariance(None, TOLERANCES), own)
    index = next(
        at for at, one in enumerate(fit.deviations) if one.deviation.effect == "joint_offset"
    )
    lone = np.zeros_like(fit.covariance)
    at = len(fit.vector) + index
    lone[at, at] = 0.004**2
    off = tuple(
        replace(one, value=0.003 if index == here else 0.0)
        for here, one in enumerate(fit.deviations)
    )
    found = support_covariance(replace(fit, covariance=lone, deviations=off), TOLERANCES) - own
    samples = fit.signal_model.samples
    robot, both, step = samples.robot, samples.both, 1e-5
    change = np.zeros(len(robot.joint_names))
    (name,) = fit.deviations[index].deviation.location
    for joint, ratio in driven_together(robot, robot.joint(name)):
        change[joint] = ratio * step
    ends = [closure(body_states(robot, samples.angles[both] + x * change)) for x in (1, -1)]
    slope = ((ends[0] - ends[1]) / (2.0 * step)).mean(axis=0)[[0, 1, 5]]
    np.testing.assert_allclose(found, 0.005**2 * np.outer(slope, slope), rtol=1e-4, atol=1e-12)
