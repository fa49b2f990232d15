"""Columns of as-built deviations against a forward model of robots and shoes that have them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from core.error_sources import world
from core.error_sources.altered import shifted
from core.error_sources.shows import ALIKE, LEAST
from core.estimation import synthetic
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.as_built import as_built, plates_column
from shoecal_core.error_sources.base import ALL
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel, make_signal_model
from shoecal_core.error_sources.signals import SIGNALS
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SEEDS = (1, 2, 3)
SIZES = {
    "link_mass": 0.05, "link_com": 2e-3, "joint_offset": 5e-4, "joint_compliance": 2e-4,
    "backlash": 1e-3, "cell_position": 1e-4, "plates": 0.01, "zero_offset": 0.02, "support": 1e-4,
}  # fmt: skip
"""Small enough to be linear, in the units of each deviation."""
WITHIN = 0.02
PUSHED = 0.05
"""N m; a softened sign of the torque, as the play's law has it."""
Layout = tuple[world.Motion, ChannelParameters, SignalModel, list[Deviation]]


def scene_of(moves: world.Motion, truth: world.Truth) -> SignalModel:
    return make_signal_model(world.recorded(moves, truth), truth.parameters, SignalSettings())


@pytest.fixture(scope="module", params=SEEDS)
def layout(request: pytest.FixtureRequest) -> Layout:
    """Random postures and supports, and a foot in the air; nothing is wrong."""
    rng = np.random.default_rng(request.param)
    moves = world.motion(rng)
    parameters = synthetic.truth(moves.shoe, rng)
    signal_model = scene_of(moves, world.Truth(parameters))
    return moves, parameters, signal_model, as_built(signal_model, Tolerances())


def truly(
    moves: world.Motion,
    parameters: ChannelParameters,
    one: Deviation,
    size: float,
    held: Callable[[FloatArray], FloatArray],
) -> world.Truth:
    """The world in which a deviation has that size, by what its name says.

    Args:
        held: joints (T, m) that give [rad], as soles on the floor let them.
    """
    robot, shoe, exact = moves.robot, moves.shoe, world.Truth(parameters)
    if one.effect == "link_mass":
        return replace(exact, robot=world.with_heavier_link(robot, one.location[0], size))
    if one.effect == "link_com":
        moved = shifted(robot, one.location[0], "xyz".index(one.component), size)
        return replace(exact, robot=moved)
    if one.effect in ("joint_offset", "joint_compliance", "backlash"):
        return replace(exact, encoder=encoder(robot, one, size, held))
    if one.effect in ("cell_position", "plates"):
        return replace(exact, columns=columns(shoe, one, size))
    if one.effect == "zero_offset":
        assert one.run is not None
        return replace(exact, zero={one.run: size * (np.array(shoe.names) == one.location[0])})
    assert one.effect == "support"
    step = size * np.eye(3)[("dx", "dy", "dtheta").index(one.component)]
    return replace(exact, support={int(one.location[0].split()[1]): step})


def encoder(
    robot: Robot, one: Deviation, size: float, held: Callable[[FloatArray], FloatArray]
) -> Callable[[FloatArray], FloatArray]:
    """What encoders show too much, from torques (T, m): an offset of all on a motor, or gears."""
    here = np.zeros(len(robot.joint_names))
    place = one.location[0]
    here[sorted(robot.moved) if place == ALL else [robot.joint(place)]] = size
    if one.effect == "joint_compliance":
        return lambda torque: held(here * torque)
    if one.effect == "backlash":
        return lambda torque: held(0.5 * here * np.tanh(torque / PUSHED))
    for shared in robot.shared:
        if shared.leader == robot.joint(place):
            here[shared.joint] = shared.ratio * size
    return lambda torque: np.tile(here, (len(torque), 1))


def columns(shoe: Shoe, one: Deviation, size: float) -> FloatArray:
    """(n, 3) truly: a force f at (x, y) turns the sole by (y f, -x f) about x and y."""
    found = shoe.columns.copy()
    axis = "xy".index(one.component)
    far = np.zeros(len(shoe.names))
    if one.effect == "cell_position":
        far[shoe.index(one.location[0])] = size
    else:
        own = shoe.of_foot(FEET.index(one.location[0]))
        far[own] = size * (shoe.positions[own, axis] - shoe.positions[own, axis].mean())
    found[:, 2 - axis] += far * (-1.0 if axis == 0 else 1.0)
    return found


@pytest.mark.parametrize("effect", SIZES)
def test_columns_are_what_is_recorded(layout: Layout, effect: str) -> None:
    """Every signal of every sample, for each place and component, in the first of its forms."""
    moves, parameters, signal_model, found = layout
    mine = {one.key: one for one in reversed(found) if one.effect == effect}
    assert mine
    for one in mine.values():
        size = SIZES[effect]
        samples = world.recorded(moves, truly(moves, parameters, one, size, signal_model.held))
        after = replace(signal_model, samples=samples)
        change, foretold = after.residuals - signal_model.residuals, size * one.column
        for signals, least in zip(ALIKE, LEAST, strict=True):
            off, most = (rms(x[:, signals]) for x in (change - foretold, change))
            names = [SIGNALS[index] for index in signals]
            assert off <= max(WITHIN * most, 1e-2 * least), (one.key, names, off, most)


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_every_source_with_a_forward_model_is_there(layout: Layout) -> None:
    """The others are held against one in `effects`."""
    elsewhere = {
        "soft_ground", "crosstalk", "foot_placement", "floor_tilt", "joint_friction", "latency",
    }  # fmt: skip
    assert {one.effect for one in layout[3]} == {*SIZES, *elsewhere}


def test_nothing_shows_where_nothing_is_wrong(layout: Layout) -> None:
    np.testing.assert_allclose(layout[2].residuals, 0.0, atol=1e-8)


def test_a_link_that_is_heavier_draws_the_cop_towards_it(layout: Layout) -> None:
    """At the same total mass; by hand for the heaviest thigh, in double support."""
    moves, parameters, signal_model, found = layout
    (one,) = (x for x in found if x.effect == "link_mass" and x.location[0] == "LThigh_link")
    both = signal_model.samples.both
    at = signal_model.links.com[both, signal_model.links.names.index("LThigh_link"), 1]
    towards = at - signal_model.samples.states.com[both, 0, 1]
    assert (towards > 0.0).all()
    assert (one.column[both, 2] > 0.0).all()
    heavier = world.recorded(moves, truly(moves, parameters, one, 0.05, signal_model.held))
    assert (replace(signal_model, samples=heavier).residuals[both, 2] > 0.0).all()


def test_shoe_columns_say_how_the_channels_measure(layout: Layout) -> None:
    """Of what moves the channels' columns, and of nothing else."""
    for one in layout[3]:
        assert (one.shoe_column is not None) == (one.effect in ("cell_position", "plates"))


def test_plates_act_about_the_middle_of_a_foot_s_cells(layout: Layout) -> None:
    shoe = layout[0].shoe
    change = plates_column(shoe, "left", "x")
    own = shoe.of_foot(0)
    assert change[own].sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    middle = shoe.positions[own, 0].mean()
    np.testing.assert_allclose(change[own, 2], -(shoe.positions[own, 0] - middle))
    assert not change[shoe.of_foot(1)].any()


@pytest.mark.parametrize("name", [one.name for one in fields(Tolerances)])
def test_what_is_exact_is_no_deviation(layout: Layout, name: str) -> None:
    """A tolerance of zero takes its source away, and no other."""
    _, _, signal_model, found = layout
    left = as_built(signal_model, replace(Tolerances(), **{name: 0.0}))
    if name == "sideways_share":  # of the expected error alone
        assert len(left) == len(found)
        return
    assert 0 < len(left) < len(found)
    assert {one.key for one in left} < {one.key for one in found}
