"""Robots with as-built errors of known size, and the joint fit of what they record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.error_sources import world
from core.error_sources.altered import shifted
from core.estimation import synthetic
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.as_built import of_body, of_shoes
from shoecal_core.error_sources.base import ALL
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import RATE_HZ, JointFit, fit_jointly
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.wrench import ChannelParameters

TOLERANCES = Tolerances(sole_compliance_rad_per_nm=0.0)
"""The forward model's soles are stiff."""
SETTINGS = SignalSettings(rate_hz=RATE_HZ)
PUSHED = 0.05
NOISE = 0.01


@dataclass(frozen=True)
class Drawn:
    """A fit and the truth.

    Attributes:
        parameters: true gains and offsets.
        values: true value of each of the fit's deviations, by key.
        fit: of what was recorded.
    """

    parameters: ChannelParameters
    values: dict[tuple[str, tuple[str, ...], str, int | None], float]
    fit: JointFit

    @cached_property
    def errors(self) -> FloatArray:
        """(2n + 1 + k,) estimate less truth, as the covariance has them in order."""
        fit = self.fit
        truth = [*self.parameters.gain, *self.parameters.offset, 0.0]
        found = [one.value - self.values[one.deviation.key] for one in fit.deviations]
        return np.concatenate((fit.vector - truth, found))


def drawn(
    seed: int,
    *,
    tolerances: Tolerances = TOLERANCES,
    share: float = 1.0,
    noise: float = NOISE,
    count: int = 24,
    believed: Tolerances | None = None,
) -> Drawn:
    """Draw every deviation by its standard deviation times a share, record, fit.

    Args:
        seed: of motion and truth.
        tolerances: that the truth is drawn by.
        share: of it; 0: nothing is wrong.
        noise: of each sample of each channel [N].
        count: samples of each run.
        believed: tolerances of the fit; None: those of the truth.
    """
    rng = np.random.default_rng(seed)
    moves = world.motion(rng, supports=5, unloading=2, count=count)
    parameters = synthetic.truth(moves.shoe, rng)
    exact = world.Truth(parameters, noise=noise)
    signal_model = make_signal_model(world.recorded(moves, exact, seed), parameters, SETTINGS)
    found = [*of_body(signal_model, tolerances), *of_shoes(signal_model, tolerances)]
    values = {one.key: share * one.std * rng.standard_normal() for one in found}
    truth = _truth(moves, exact, found, values, signal_model.held)
    samples = world.recorded(moves, truth, seed)
    guess = ChannelParameters(
        parameters.gain * 1.15, parameters.offset + rng.normal(0.0, 2.0, len(parameters.offset))
    )
    fit = fit_jointly(
        samples,
        samples.runs,
        guess,
        SETTINGS,
        believed or tolerances,
        time_offset_std_s=0.02,
    )
    return Drawn(parameters, values, fit)


def _truth(
    moves: world.Motion,
    exact: world.Truth,
    found: list[Deviation],
    values: dict[tuple[str, tuple[str, ...], str, int | None], float],
    held: Callable[[FloatArray], FloatArray],
) -> world.Truth:
    """Everything at once; joints (T, m) that give [rad] are held by soles on the floor."""
    robot, columns = moves.robot, moves.shoe.columns.copy()
    support: dict[int, FloatArray] = {}
    zero: dict[int, FloatArray] = {}
    for one in found:
        value, place = values[one.key], one.location[0]
        if one.effect == "link_mass":
            robot = world.with_heavier_link(robot, place, value)
        elif one.effect == "link_com":
            robot = shifted(robot, place, "xyz".index(one.component), value)
        elif one.shoe_column is not None:
            columns = columns + value * one.shoe_column
        elif one.effect == "zero_offset":
            assert one.run is not None
            own = zero.setdefault(one.run, np.zeros(len(moves.shoe.names)))
            own += value * (np.array(moves.shoe.names) == place)
        elif one.effect == "support":
            moved = support.setdefault(int(place.split()[1]), np.zeros(3))
            moved[("dx", "dy", "dtheta").index(one.component)] = value
    joints = {
        name: _of_joints(moves.robot, name, found, values)
        for name in ("joint_offset", "joint_compliance", "backlash")
    }
    return world.Truth(
        exact.parameters, robot, columns, _encoder(joints, held), support, zero, exact.noise
    )


def _encoder(
    joints: dict[str, FloatArray], held: Callable[[FloatArray], FloatArray]
) -> Callable[[FloatArray], FloatArray]:
    def shown(torque: FloatArray) -> FloatArray:
        pushed = 0.5 * joints["backlash"] * np.tanh(torque / PUSHED)
        return joints["joint_offset"] + held(joints["joint_compliance"] * torque + pushed)

    return shown


def _of_joints(
    robot: Robot,
    effect: str,
    found: list[Deviation],
    values: dict[tuple[str, tuple[str, ...], str, int | None], float],
) -> FloatArray:
    """(m,) of each joint: what all have in common, and its own; encoders tell of whole motors."""
    each = np.zeros(len(robot.joint_names))
    for one in found:
        if one.effect != effect:
            continue
        if one.location[0] == ALL:
            each[list(robot.moved)] += values[one.key]
            continue
        joint = robot.joint(one.location[0])
        each[joint] += values[one.key]
        if effect == "joint_offset":
            for shared in robot.shared:
                if shared.leader == joint:
                    each[shared.joint] += shared.ratio * values[one.key]
    return each
