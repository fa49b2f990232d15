"""Own steps and lifted feet in the physics: gears give, encoders and masses are off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely

from core.cli.conftest import Run
from core.planning.motions import planner_of
from core.simulation.worlds import DEFAULT, load_world
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import PUT_DOWN
from shoecal_core.planning.planner import StartError
from shoecal_core.planning.steps import Stepper
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.workflows.simulated_session import take, walk

START = DoubleSupport(0.0, -0.12, 0.0)
GOALS = (
    DoubleSupport(0.04, -0.112, 0.156),
    DoubleSupport(-0.03, -0.128, -0.26),
    DoubleSupport(0.05, -0.132, 0.312),
)
FEET_ERROR = {"nao": 0.008, "odd_biped": 0.015}
"""m; what gears give beyond what encoders show, and friction holds then."""
YAW_ERROR = 0.02
"""rad."""


@dataclass(frozen=True)
class Seen:
    """One look at a stepping robot: where it is in its motion, and the truth."""

    phase: str
    support_phase: SupportPhase
    since: float
    force: FloatArray
    gap: float
    height: float
    tilt: float


def way_between(sim: SimulatedRobot) -> tuple[FloatArray, float]:
    """(2,) true place of the right sole seen from the left one [m], and its yaw [rad]."""
    snap = sim.snapshot()
    way = snap.sole_rotation[0].T @ (snap.sole_position[1] - snap.sole_position[0])
    turn = snap.sole_rotation[0].T @ snap.sole_rotation[1]
    return way[:2], float(np.arctan2(turn[1, 0], turn[0, 0]))


def looking_on(sim: SimulatedRobot, seen: list[Seen]) -> Callable[[Motion, float], None]:
    def look(motion: Motion, since: float) -> None:
        now = min(since, motion.duration)
        phase = next(one for one in motion.phases if now <= one.end)
        snap = sim.snapshot()
        left, right = (
            shapely.Polygon(place[:2] + foot.outline @ turn[:2, :2].T)
            for place, turn, foot in zip(
                snap.sole_position, snap.sole_rotation, sim.robot.feet, strict=True
            )
        )
        force = sim.truth(snap).foot_grf
        done = (now - phase.begin) / (phase.end - phase.begin)
        gap, foot = float(left.distance(right)), 1 - phase.support_phase.standing
        outline = sim.robot.feet[foot].outline
        flat = np.column_stack([outline, np.zeros(len(outline))])
        corners = snap.sole_position[foot] + flat @ snap.sole_rotation[foot].T
        x, y = snap.base_orientation[:2]
        tilt = float(np.arccos(1.0 - 2.0 * (x * x + y * y)))
        height = float(corners[:, 2].min())
        seen.append(Seen(phase.name, phase.support_phase, done, force, gap, height, tilt))

    return look


def lifted_force(seen: list[Seen]) -> FloatArray:
    """Forces on the feet that are in the air, away from the ends of their phases [N]."""
    return np.array(
        [
            one.force[0 if one.support_phase is SupportPhase.RIGHT else 1]
            for one in seen
            if one.support_phase is not SupportPhase.BOTH and 0.4 < one.since < 0.6
        ]
    )


@cache
def walked() -> tuple[list[tuple[FloatArray, float]], list[Seen], list[Motion]]:
    sim = load_world("nao").simulate(DEFAULT, seed=2)
    planner, seen = planner_of("nao"), list[Seen]()
    stepper = Stepper(planner)
    sim.place(planner.stance(START))
    ends, motions = [], []
    for goal in GOALS:
        motions += walk(sim, stepper, goal, looking_on(sim, seen))
        ends.append(way_between(sim))
    assert walk(sim, stepper, GOALS[-1]) == []
    return ends, seen, motions


def test_steps_end_where_they_should_by_the_truth() -> None:
    ends, _, motions = walked()
    assert len(motions) >= len(GOALS)
    for (way, yaw), goal in zip(ends, GOALS, strict=True):
        assert np.linalg.norm(way - goal.translation) < FEET_ERROR["nao"]
        assert abs(yaw - goal.dtheta) < YAW_ERROR


def test_a_carried_foot_is_in_the_air_and_touches_nothing() -> None:
    _, seen, _ = walked()
    force = lifted_force(seen)
    assert len(force) > 10
    np.testing.assert_array_equal(force, 0.0)
    assert min(one.gap for one in seen) > 0.0
    # What gears take has been added: 15 mm are asked for.
    high = [one.height for one in seen if one.phase == "swing" and 0.4 < one.since < 0.6]
    assert min(high) > 0.010
    assert max(one.tilt for one in seen) < 0.41


@pytest.mark.parametrize(("motion", "side"), [("unload_left", 0), ("unload_right", 1)])
@pytest.mark.parametrize("name", ["nao", "odd_biped"])
def test_an_unloaded_foot_has_no_load(name: str, motion: str, side: int) -> None:
    sim, planner = load_world(name).simulate(DEFAULT, seed=1), planner_of(name)
    sim.place(planner.stance(START))
    begin, seen = way_between(sim), list[Seen]()
    planned = planner.plan_from(sim.joints().angles, motion)
    take(sim, planned, looking_on(sim, seen))
    held = [one.force for one in seen if one.phase == "lift" and one.since > 0.4]
    assert len(held) > 50
    forces = np.array(held)
    # The robot swings a little when it comes to rest: a corner may touch once more.
    assert np.median(forces[:, side]) == 0.0
    assert forces[:, side].max() < 0.02 * sim.weight
    np.testing.assert_allclose(forces[:, 1 - side], sim.weight, rtol=0.05)
    way, yaw = way_between(sim)
    assert np.linalg.norm(way - begin[0]) < FEET_ERROR[name]
    assert abs(yaw - begin[1]) < YAW_ERROR


def test_a_session_by_own_steps(shoecal: Run, tmp_path: Path) -> None:
    """Placed once; its runs are the motions asked for, in the stances asked for."""
    folder = tmp_path / "session"
    config = Path(__file__).resolve().parents[3] / "config"
    code, _, _ = shoecal(
        "simulate", config / "robots" / "nao.yaml", config / "shoes" / "nao_shoe.yaml",
        "--stance", "neutral", "toes_out", "--own-steps", "--motion", "faster",
        "--rate", "50", "--out", folder,
    )  # fmt: skip
    assert code == 0
    first, second = Session.open(folder).runs
    assert [run.info.motion for run in (first, second)] == ["faster", "faster"]
    assert first.info.support is not None
    assert second.info.support is not None
    assert first.info.support.dtheta == 0.0
    assert second.info.support.dtheta < -0.2


def test_names_are_listed_and_others_refused(
    shoecal: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        shoecal("simulate", "--help")
    told = " ".join(capsys.readouterr().out.split())
    for name in ("unload_left (the left foot lifted", "torso_tilt", "toes_in (turned inward"):
        assert name in told
    for words in (
        ["--motion", "dance"],
        ["--stance", "split"],
        ["--stance", "wide", "--supports", "2"],
    ):
        with pytest.raises(SystemExit) as caught:
            shoecal("simulate", "a.yaml", "b.yaml", *words, "--out", "s")
        assert caught.value.code == 2


@pytest.mark.parametrize("part", [0.2, 0.7])
def test_stopped_in_the_air_the_foot_is_put_down(part: float) -> None:
    """The robot holds on one foot, refuses what both feet must carry, and lands on both."""
    planner, sim = planner_of("nao"), load_world("nao").simulate(DEFAULT, seed=1)
    sim.place(planner.stance(START))
    step = Stepper(planner).step(sim.joints().angles, GOALS[0])
    assert step is not None
    swing = step.phases[1]
    sim.command(JointTrajectory(step.joint_names, step.time, step.positions))
    begun = sim.time
    sim.step_to(begun + swing.begin + part * (swing.end - swing.begin))
    held = sim.joints().angles
    sim.command(JointTrajectory(step.joint_names, np.array([0.5]), held[None]))
    sim.step_to(sim.time + 5.0)
    sim.check_upright()
    air = 1 if swing.support_phase is SupportPhase.LEFT else 0
    assert sim.truth().foot_grf[air] < 0.1 * sim.weight
    with pytest.raises(StartError, match="put_down"):
        planner.plan_from(sim.joints().angles)
    take(sim, planner.plan_from(sim.joints().angles, PUT_DOWN))
    assert sim.truth().foot_grf.min() > 0.25 * sim.weight
    planner.standing(sim.joints().angles)
