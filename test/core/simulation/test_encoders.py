from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.simulation.worlds import PERFECT, World, changed
from shoecal_core.simulation.joint_sensors import Encoders
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw, draw_body

AMPLITUDE, PHASE, ZERO = 0.01, 0.7, 0.003


def test_an_error_once_a_turn_is_a_sine_about_the_zero(nao: World) -> None:
    knee = nao.robot.joint("LKneePitch")
    body = draw_body(changed(PERFECT), nao.robot, nao.shoe, 1)
    eccentricity, zero = body.eccentricity.copy(), body.encoder_error.copy()
    eccentricity[knee], zero[knee] = (AMPLITUDE, PHASE), ZERO
    encoders = Encoders(dataclasses.replace(body, eccentricity=eccentricity, encoder_error=zero))
    angles = np.zeros((361, len(body.joints)))
    angles[:, knee] = np.linspace(0.0, 2.0 * np.pi, 361)
    error = (encoders.shown(angles) - angles)[:, knee]
    assert error[0] == pytest.approx(ZERO) == pytest.approx(error[-1])
    # Of a sine about any mean: the first harmonic is all there is, and it has the amplitude.
    harmonics = np.abs(np.fft.rfft(error[:-1])) / 180.0
    assert harmonics[1] == pytest.approx(AMPLITUDE)
    assert harmonics[2:] == pytest.approx(np.zeros(len(harmonics) - 2), abs=1e-12)
    assert encoders.angles(encoders.shown(angles)) == pytest.approx(angles, abs=1e-12)
    others = np.delete(encoders.shown(angles) - angles, knee, axis=1)
    assert not others.any()


def test_joints_of_one_motor_share_its_encoder(nao: World) -> None:
    body = draw_body(changed(PERFECT, joints__eccentricity_std_rad=0.01), nao.robot, nao.shoe, 3)
    encoders = Encoders(body)
    shared = nao.robot.shared[0]
    angles = np.zeros(len(body.joints))
    angles[shared.leader] = 0.4
    angles[shared.joint] = shared.ratio * 0.4
    shown = encoders.shown(angles)
    assert shown[shared.joint] == pytest.approx(shared.ratio * shown[shared.leader])
    assert shown[shared.leader] != pytest.approx(0.4, abs=1e-5)


def test_amplitudes_and_phases_are_drawn_without_touching_what_else_is(nao: World) -> None:
    rules = changed(PERFECT, joints__encoder_error_std_rad=0.002)
    waves = changed(rules, joints__eccentricity_std_rad=0.002)
    drawn = [draw_body(waves, nao.robot, nao.shoe, seed) for seed in range(200)]
    plain = [draw_body(rules, nao.robot, nao.shoe, seed) for seed in range(3)]
    for one, other in zip(drawn, plain, strict=False):
        assert (one.encoder_error == other.encoder_error).all()
        assert not other.eccentricity.any()
    amplitude, phase = np.concatenate([one.eccentricity[:6] for one in drawn]).T
    # Two independent normal parts: Rayleigh amplitudes, phases from anywhere.
    assert amplitude.mean() == pytest.approx(0.002 * np.sqrt(np.pi / 2.0), rel=0.05)
    assert abs(np.exp(1j * phase).mean()) < 0.1


def test_the_servo_follows_an_encoder_that_is_wrong(nao: World) -> None:
    """So the link truly stands elsewhere, and readings hide it."""
    knee = nao.robot.joint("LKneePitch")
    drawn = draw(PERFECT, nao.robot, nao.shoe, 1)
    eccentricity = drawn.body.eccentricity.copy()
    eccentricity[knee] = AMPLITUDE, PHASE
    body = dataclasses.replace(drawn.body, eccentricity=eccentricity)
    sims = [
        SimulatedRobot(
            nao.robot, nao.shoe, dataclasses.replace(drawn, body=one), np.random.default_rng(1)
        )
        for one in (drawn.body, body)
    ]
    for sim in sims:
        sim.place(nao.robot.posture)
    told = nao.robot.posture[knee]
    truly = [sim.data.qpos[sim.physics.positions[knee]] for sim in sims]
    shown = [sim.joints().angles[knee] for sim in sims]
    expected = AMPLITUDE * (np.sin(told + PHASE) - np.sin(PHASE))
    assert shown[1] == pytest.approx(shown[0], abs=2e-3)
    assert truly[1] - truly[0] == pytest.approx(shown[1] - shown[0] - expected, abs=2e-5)
