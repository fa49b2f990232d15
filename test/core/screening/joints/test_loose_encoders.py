"""A joint's zero that moves while a session is recorded is found by feet that stay in place."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.estimation.test_leg_geometry import AHEAD_M, NOISE_RAD, bends
from core.screening.recordings import SETTINGS, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.joints.legs import Legs
from shoecal_core.screening.joints.loose_encoders import (
    LooseEncoder,
    describe_loose_encoder,
    loose_encoder,
)
from shoecal_core.screening.screen import screen
from shoecal_core.workspace import config_dir

NAO = load_robot(config_dir() / "robots/nao.yaml")
KINEMATICS = Kinematics(NAO)
RECORDED = recording(count=len(AHEAD_M), seconds=1.0)
EXACT = {run: bends(NAO, ahead) for run, ahead in enumerate(AHEAD_M, start=1)}
RATE = 10.0
JOINTS = st.sampled_from(("LHipRoll", "LAnkleRoll", "RAnkleRoll"))
CREEPING = st.sampled_from(("LAnkleRoll", "RAnkleRoll"))
"""This robot bends its knees alone: of hips' rolls, jumps show, and no slow creep."""
SIZES = st.floats(0.055, 0.08)
SIGNS = st.sampled_from((-1.0, 1.0))
FEW = settings(max_examples=4, deadline=None, derandomize=True)


def found(angles: Mapping[int, FloatArray], seed: int = 0) -> LooseEncoder | None:
    """By runs of joint angles (T, m), read with noise [rad]."""
    rng = np.random.default_rng(seed)
    aligned = {}
    for run, exact in angles.items():
        read = exact + NOISE_RAD * rng.standard_normal(exact.shape)
        time = np.arange(len(read)) / RATE
        aligned[run] = Aligned(time, np.zeros((len(read), 8)), read, KINEMATICS.states(read))
    return loose_encoder(RECORDED.runs, aligned, RECORDED.shoe, KINEMATICS)


def read_with(joint: str, courses: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
    """Angles with an error of one joint: (T,) by run [rad]."""
    column = np.eye(len(NAO.joint_names))[NAO.joint(joint)]
    return {run: one + np.outer(courses[run], column) for run, one in EXACT.items()}


def creeping(size: float) -> dict[int, FloatArray]:
    count = len(EXACT[1])
    whole = size * np.arange(len(EXACT) * count) / (len(EXACT) * count - 1)
    return {run: whole[(run - 1) * count : run * count] for run in EXACT}


def jumping(size: float, run: int, at: int) -> dict[int, FloatArray]:
    """At a sample of a run; later runs keep it."""
    since = (np.arange(len(EXACT[1])) >= at).astype(np.float64)
    return {one: size * (since if one == run else np.full(len(since), one > run)) for one in EXACT}


@FEW
@given(seed=st.integers(0, 99), joint=CREEPING, size=SIZES, sign=SIGNS)
def test_a_zero_that_creeps_is_named(seed: int, joint: str, size: float, sign: float) -> None:
    one = found(read_with(joint, creeping(sign * size)), seed)
    assert one is not None
    assert joint in one.joints
    assert one.zeros[1][0] == 0.0
    assert one.zeros[3][1] == pytest.approx(sign * size, rel=0.2)


@FEW
@given(seed=st.integers(0, 99), joint=JOINTS, size=SIZES, sign=SIGNS, at=st.integers(35, 55))
def test_a_zero_that_jumps_is_named_with_its_time(
    seed: int, joint: str, size: float, sign: float, at: int
) -> None:
    one = found(read_with(joint, jumping(sign * size, 2, at)), seed)
    assert one is not None
    assert joint in one.joints
    assert one.jump is not None
    assert one.jump[0] == 2
    assert one.jump[1] == pytest.approx(at / RATE, abs=1.0)


@FEW
@given(seed=st.integers(0, 99), joint=JOINTS, zero=st.floats(-0.06, 0.06))
def test_zeros_and_scales_that_are_off_do_not_move(seed: int, joint: str, zero: float) -> None:
    off = read_with(joint, {run: np.full(len(one), zero) for run, one in EXACT.items()})
    assert found(off, seed) is None
    assert found(read_with(joint, {run: np.zeros(len(one)) for run, one in EXACT.items()})) is None
    scale = 1.0 + 0.05 * np.eye(len(NAO.joint_names))[NAO.joint(joint)]
    assert found({run: scale * one for run, one in EXACT.items()}, seed) is None


@pytest.mark.parametrize("run", [1, 2, 3])
@pytest.mark.parametrize("joint", ["RAnkleRoll", "LAnklePitch"])
def test_a_foot_on_its_edge_until_the_end_of_a_run_is_no_zero(run: int, joint: str) -> None:
    edge = 0.03 * (np.arange(len(EXACT[1])) >= 50)
    on_edge = {one: np.asarray(edge * (one == run)) for one in EXACT}
    assert found(read_with(joint, on_edge)) is None


def test_a_foot_that_slips_is_no_zero() -> None:
    half = len(EXACT[2]) // 2
    slipped = np.concatenate((EXACT[2][:half], bends(NAO, AHEAD_M[1] + 0.006)[half:]))
    assert found({**EXACT, 2: slipped}) is None


def test_one_run_shows_no_course() -> None:
    assert found({1: EXACT[1]}) is None
    assert found({}) is None


def test_it_is_refused_before_all_that_it_looks_like() -> None:
    zeros = {1: (0.0, 0.012), 2: (0.012, 0.06)}
    loose = LooseEncoder(("RHipRoll",), zeros)
    said = screen(
        RECORDED.runs, RECORDED.aligned, RECORDED.shoe, 54.0, SETTINGS, legs=Legs(loose=loose)
    )
    assert said.fails
    assert said.findings[-1].fault is Fault.JOINT_ZERO
    assert "the zero of RHipRoll moves, from 0 in run 1 to 60 mrad in run 2" in (
        said.findings[-1].reason
    )


def test_the_words() -> None:
    assert describe_loose_encoder(None) == []
    steps = {1: (0.0, 0.0), 2: (0.03, 0.03), 4: (-0.01, -0.01)}
    (finding,) = describe_loose_encoder(LooseEncoder(("a", "b"), steps))
    assert "of a (or of b) moves from run to run (0, 30, -10 mrad in runs 1, 2, 4)" in (
        finding.reason
    )
    (finding,) = describe_loose_encoder(LooseEncoder(("a",), {1: (0.0, -0.02)}, (1, 12.84)))
    assert "the zero of a jumps by 20 mrad in run 1 (at 12.8 s): its magnet" in finding.reason
