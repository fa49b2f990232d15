from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.shoe.shoes import made, six_axis
from core.simulation.worlds import DEFAULT, World, changed
from shoecal_core.files import read_yaml, write_yaml
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.simulation.effects.contact import FloorTilt
from shoecal_core.simulation.effects.timing import Latency
from shoecal_core.simulation.sampled_robot import draw, draw_shoes

SEEDS = range(200)


def test_a_seed_draws_the_same_and_another_does_not(world: World) -> None:
    one, same, other = (draw(DEFAULT, world.robot, world.shoe, seed) for seed in (3, 3, 4))
    assert one.record() == same.record()
    assert (one.shoes.parameters.gain != other.shoes.parameters.gain).all()
    assert (one.body.encoder_error != other.body.encoder_error).all()


def test_shoes_do_not_depend_on_who_wears_them(nao: World) -> None:
    worn = draw(DEFAULT, nao.robot, nao.shoe, 5).shoes
    alone = draw_shoes(DEFAULT, nao.shoe, 5)
    assert (worn.parameters.gain == alone.parameters.gain).all()
    assert (worn.position == alone.position).all()


def test_draws_have_the_spread_that_is_asked_for(nao: World) -> None:
    shoes = [draw_shoes(DEFAULT, nao.shoe, seed) for seed in SEEDS]
    nominal = DEFAULT.cells.full_scale_n / 5.0
    gains = np.abs([one.parameters.gain for one in shoes]) / nominal
    assert gains.min() > 0.7
    assert gains.max() < 1.3
    assert gains.std() == pytest.approx(0.6 / np.sqrt(12.0), rel=0.05)
    shifts = np.array([one.position - nao.shoe.positions for one in shoes])
    assert shifts.std() == pytest.approx(DEFAULT.cells.position_error_std_m, rel=0.05)


def test_polarity_is_the_shoes_and_drawn_where_unknown(nao: World) -> None:
    for seed in range(5):
        gain = draw_shoes(DEFAULT, nao.shoe, seed).parameters.gain
        assert (np.sign(gain) == nao.shoe.polarity).all()
    channels = tuple(dataclasses.replace(one, polarity=0) for one in nao.shoe.channels)
    unknown = dataclasses.replace(nao.shoe, channels=channels)
    signs = {tuple(np.sign(draw_shoes(DEFAULT, unknown, seed).parameters.gain)) for seed in SEEDS}
    assert len(signs) > 50


def test_listed_numbers_take_the_place_of_drawn_ones(nao: World) -> None:
    rules = changed(
        DEFAULT,
        body__mass_error_fraction={"base": 0.25},
        joints__encoder_error_rad={"all": 0.0, "LHipYawPitch": 0.01},
    )
    body = draw(rules, nao.robot, nao.shoe, 1).body
    assert body.mass_factor[0] == 1.25
    assert (body.mass_factor[1:] != 1.0).all()
    # The right hip's yaw-pitch is the left one's motor, with its encoder.
    wrong = [body.joints[index] for index in np.flatnonzero(body.encoder_error)]
    assert wrong == ["LHipYawPitch", "RHipYawPitch"]


def test_play_for_all_means_the_legs(nao: World) -> None:
    rules = changed(DEFAULT, joints__play_rad={"all": 0.004, "HeadYaw": 0.01})
    body = draw(rules, nao.robot, nao.shoe, 1).body
    play = dict(zip(body.joints, body.play, strict=True))
    assert play["LKneePitch"] == play["RHipYawPitch"] == 0.004
    assert play["HeadYaw"] == 0.01
    assert play["LElbowYaw"] == 0.0


def test_gears_differ_from_joint_to_joint(nao: World) -> None:
    spread = 0.5
    rules = changed(DEFAULT, joints__compliance_spread_fraction=spread)
    drawn = [draw(rules, nao.robot, nao.shoe, seed).body for seed in SEEDS]
    factors = np.array([body.compliance[nao.robot.moved] for body in drawn]) / 0.0045
    assert factors.min() > 0.0
    assert factors.mean() == pytest.approx(1.0, abs=0.05)
    assert factors.std() == pytest.approx(spread, abs=0.05)
    # What else is drawn stays as it is.
    plain = draw(DEFAULT, nao.robot, nao.shoe, SEEDS[0]).body
    assert (plain.encoder_error == drawn[0].encoder_error).all()
    assert (plain.com_error == drawn[0].com_error).all()
    assert (plain.compliance[nao.robot.moved] == 0.0045).all()


def test_friction_is_a_share_of_the_legs_torque_limits(nao: World) -> None:
    rules = changed(
        DEFAULT, joints__static_friction_fraction=0.1, joints__kinetic_friction_fraction=0.05
    )
    friction = draw(rules, nao.robot, nao.shoe, 1).body.friction
    knee = nao.robot.joint("LKneePitch")
    assert friction[knee] == pytest.approx([0.30226, 0.15113], abs=1e-4)
    assert not friction[nao.robot.joint("HeadYaw")].any()


def test_the_scale_is_off_by_what_is_asked(world: World) -> None:
    rules = changed(DEFAULT, body__weight_error_n=0.5)
    body = draw(rules, world.robot, world.shoe, 1).body
    assert (body.mass + world.shoe.mass - world.robot.mass) * GRAVITY == pytest.approx(0.5)


def test_effects_add_up(nao: World) -> None:
    rules = changed(
        DEFAULT, Latency(("left",), 0.02), Latency(("left", "right"), 0.01), FloorTilt(0.1, -0.2)
    )
    shoes = draw(rules, nao.robot, nao.shoe, 1).shoes
    assert shoes.latency == pytest.approx([0.03] * 4 + [0.01] * 4)
    assert shoes.tilt == pytest.approx([0.1, -0.2])


def test_the_record_can_be_read_again(world: World, tmp_path: Path) -> None:
    drawn = draw(DEFAULT, world.robot, world.shoe, 1)
    write_yaml(tmp_path / "drawn.yaml", drawn.record())
    fields = read_yaml(tmp_path / "drawn.yaml")
    for name, gain in zip(world.shoe.names, drawn.shoes.parameters.gain, strict=True):
        assert fields.mapping("gain").number(name) == gain


def test_sensors_with_data_sheets_are_about_as_these_say() -> None:
    shoe = made([*six_axis(0, [0, 0, 0.05], gain=2.0), *six_axis(1, [0, 0, 0.05], gain=None)])
    gains = np.array([draw_shoes(DEFAULT, shoe, seed).parameters.gain for seed in SEEDS])
    known, unknown = np.abs(gains[:, :5]) / 2.0, np.abs(gains[:, 5:])
    assert known.mean() == pytest.approx(1.0, abs=0.002)
    assert known.std() == pytest.approx(DEFAULT.cells.nominal_gain_std_fraction, rel=0.1)
    assert (unknown.std(axis=0) / unknown.mean(axis=0)).min() > 0.1
