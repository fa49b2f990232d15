"""Faults that befall the robot itself: one run is simulated again with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.ndimage import median_filter

from fault_draws import Draw, Expected, Injected, NoFaultError
from population import RATE_HZ, nao
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.screening.faults import Fault
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.disturbances import Disturbance, Push
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.slip import DURATION, Slip
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw as draw_robot
from shoecal_core.simulation.samples import SimulatedSamples, run
from shoecal_core.workspace import config_dir

HOLD_S = 1.0
SETTLING_S = 1.5
BROKEN_M = 0.005
"""m; a CoP farther off what slow motion makes of it is none of a robot that stands still."""
LEAST_SAMPLES = 20
NOT_STILL = (Fault.TOO_FAST, Fault.DISTURBED)
"""Whether the joints show it or the cells alone, the robot does not stand still."""


def wrong_weight(draw: Draw) -> Injected:
    """In one run the robot carries 1.8 to 10 N on its torso or in a hand, or is held by as much."""
    number, rng = draw.run(), draw.rng
    size = float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(1.8), np.log(10.0))))
    link = str(rng.choice(["base_link", "l_gripper_link", "r_gripper_link"]))
    load = Push(link, np.array([0.0, 0.0, -size]), 0.0, 1e9)
    samples, _ = _again(draw, number, [load], settled=True)
    expected = Expected(
        (Fault.WRONG_WEIGHT,),
        words=(f"run {number}", "recorded with", "more" if size > 0.0 else "less"),
        run=number,
        times=samples.time - samples.time[0],
    )
    return Injected({number: _run(draw, number, samples)}, expected)


def jolt(draw: Draw) -> Injected:
    """Something pushes the torso sideways by 1.5 to 15 N for 0.05 to 0.4 s."""
    number, rng = draw.run(), draw.rng
    start, duration = _moment(draw, number), float(rng.uniform(0.05, 0.4))
    size, way = np.exp(rng.uniform(np.log(1.5), np.log(15.0))), rng.uniform(0.0, 2.0 * np.pi)
    force = size * np.array([np.cos(way), np.sin(way), rng.uniform(-0.5, 0.5)])
    samples, _ = _again(draw, number, [Push("base_link", force, start, start + duration)])
    time = samples.time - samples.time[0]
    expected = Expected(
        NOT_STILL,
        run=number,
        times=time[(time >= start + 0.02) & (time <= start + duration)],
    )
    return Injected({number: _run(draw, number, samples)}, expected)


def hasty(draw: Draw) -> Injected:
    """For 3 to 8 s of its plan the robot moves 3 to 7 times too fast."""
    number, rng = draw.run(), draw.rng
    haste, length = float(rng.uniform(3.0, 7.0)), float(rng.uniform(3.0, 8.0))
    commanded = draw.runs[number].commanded[0]
    start = float(rng.uniform(2.0, max(2.5, commanded.time[-1] - length - 2.0)))
    inside = np.clip(commanded.time - start, 0.0, length)
    warped = commanded.time - inside * (1.0 - 1.0 / haste)
    samples, model = _again(draw, number, [], times=warped)
    off = _fast_part(samples.truth.cop - model)
    times = (samples.time - samples.time[0])[off > BROKEN_M]
    _require(len(times) >= LEAST_SAMPLES)
    expected = Expected(NOT_STILL, run=number, times=times)
    return Injected({number: _run(draw, number, samples)}, expected)


def lifted(draw: Draw) -> Injected:
    """A leg is drawn up while the other foot carries most, for 0.6 to 2 s."""
    number, rng = draw.run(), draw.rng
    truth = read_truth(Session.open(draw.member.folder).truth_path(number))
    share = truth.foot_grf.min(axis=1) / truth.foot_grf.sum(axis=1)
    inner = (truth.time > 2.0) & (truth.time < truth.time[-1] - 3.0)
    _require(bool((share[inner] < 0.35).any()))
    middle = float(truth.time[inner][np.argmin(share[inner])]) + float(rng.uniform(-0.5, 0.5))
    foot = int(np.argmin(truth.foot_grf[np.searchsorted(truth.time, middle)]))
    length, bend = float(rng.uniform(0.6, 2.0)), float(rng.uniform(0.3, 0.8))
    samples, _ = _again(draw, number, [], drawn_up=(foot, middle - HOLD_S, length, bend))
    time = samples.time - samples.time[0]
    up = (samples.truth.foot_grf[:, foot] < 0.2) & (np.abs(time - middle) < length)
    _require(int(up.sum()) >= LEAST_SAMPLES)
    expected = Expected((Fault.LIFTED,), run=number, times=time[up])
    return Injected({number: _run(draw, number, samples)}, expected)


def slip(draw: Draw) -> Injected:
    """A foot loses its grip, is pulled, and comes to rest 3 to 10 mm from where it stood."""
    number, rng = draw.run(), draw.rng
    start, foot = _moment(draw, number), int(rng.integers(2))
    way, far = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.004, 0.013)
    shift = (far * float(np.cos(way)), far * float(np.sin(way)), 0.0)
    samples, _ = _again(draw, number, [], effects=[Slip((FEET[foot],), shift, start, run=1)])
    time = samples.time - samples.time[0]
    before, after = time < start - 0.05, time > start + DURATION + 0.5
    moved = _apart(samples)
    shift = moved[after][:50].mean(axis=0) - moved[before][-50:].mean(axis=0)
    size = float(np.linalg.norm(shift))
    _require(0.003 <= size <= 0.010)
    expected = Expected(
        (Fault.SLIPPED,),
        words=("a foot slipped", f"run {number}"),
        run=number,
        times=time[time > start + DURATION],
    )
    return Injected({number: _run(draw, number, samples)}, expected)


PHYSICS: Mapping[str, Callable[[Draw], Injected]] = {
    "wrong weight": wrong_weight,
    "jolt": jolt,
    "hasty motion": hasty,
    "lifted foot": lifted,
    "slipped foot": slip,
}


def _again(
    draw: Draw,
    number: int,
    disturbances: Sequence[Disturbance],
    *,
    times: FloatArray | None = None,
    drawn_up: tuple[int, float, float, float] | None = None,
    settled: bool = False,
    effects: Sequence[Effect] = (),
) -> tuple[SimulatedSamples, FloatArray]:
    """The run simulated again, with what befalls it, and the modelled CoP of its joint angles."""
    robot, shoe = nao()
    recorded = draw.runs[number]
    commanded = recorded.commanded[0]
    positions = commanded.position
    time = commanded.time if times is None else times
    if drawn_up is not None:
        time, positions = _drawn_up(commanded.names, time, positions, *drawn_up)
    rules = replace(_reality(), effects=tuple(effects))
    reality = draw_robot(rules, robot, shoe, draw.member.robot_seed)
    sim = SimulatedRobot(robot, shoe, reality, np.random.default_rng([draw.number, number, 5]))
    support = recorded.info.support
    assert support is not None
    try:
        sim.place(_planner().stance(support))
        if settled:
            sim.begin_run(disturbances)
            sim.step_to(sim.time + SETTLING_S)
        trajectory = JointTrajectory(commanded.names, time, positions)
        samples = run(sim, trajectory, RATE_HZ, hold=HOLD_S, disturbances=disturbances)
    except ShoecalError as error:
        raise NoFaultError(str(error)) from error
    return samples, _kinematics().states(samples.joints.angles).cop[:, 0]


def _drawn_up(
    names: Sequence[str],
    time: FloatArray,
    positions: FloatArray,
    foot: int,
    middle: float,
    length: float,
    bend: float,
) -> tuple[FloatArray, FloatArray]:
    """A trajectory in which one leg's knee bends more for a while, its sole staying level."""
    fine = np.arange(time[0], time[-1], 0.05)
    placed = JointTrajectory(tuple(names), time, positions).at(fine)
    phase = np.clip((fine - middle) / length + 0.5, 0.0, 1.0)
    more = bend * np.sin(np.pi * phase) ** 2
    side = "LR"[foot]
    for joint, factor in ((f"{side}HipPitch", -1.0), (f"{side}KneePitch", 2.0),
                          (f"{side}AnklePitch", -1.0)):  # fmt: skip
        placed[:, list(names).index(joint)] += factor * more
    return fine, placed


def _run(draw: Draw, number: int, samples: SimulatedSamples) -> Run:
    """The recorded run with what was simulated in place of what was recorded."""
    recorded = draw.runs[number]
    time = samples.time - samples.time[0]
    shape = samples.readings.voltages.shape
    joints = replace(
        recorded.joints, time=time, position=samples.joints.angles, effort=samples.joints.efforts
    )
    readings = replace(
        recorded.readings,
        time=time,
        value=samples.readings.voltages,
        status=samples.readings.status,
        sequence=np.broadcast_to(np.arange(len(time))[:, None], shape),
        temperature=np.full(shape, np.nan),
    )
    return draw.converter.read(replace(recorded, joints=joints, readings=readings), draw.rng)


def _apart(samples: SimulatedSamples) -> FloatArray:
    """(T, 2) from the true left to the true right sole, over the floor [m]."""
    return samples.sole_position[:, 1, :2] - samples.sole_position[:, 0, :2]


def _fast_part(off: FloatArray) -> FloatArray:
    """(T,) length of what (T, 2) does within less than two seconds."""
    slow = median_filter(off, size=(round(2.0 * RATE_HZ) + 1, 1), mode="nearest")
    return np.asarray(np.linalg.norm(off - slow, axis=1))


def _moment(draw: Draw, number: int) -> float:
    """A time within the run, not too near to its ends [s]."""
    end = float(draw.runs[number].readings.time[-1])
    return float(draw.rng.uniform(0.12, 0.85) * end)


def _require(came_about: bool) -> None:
    if not came_about:
        raise NoFaultError("the fault did not come about")


@cache
def _planner() -> Planner:
    return Planner(nao()[0], PlannerSettings())


@cache
def _kinematics() -> Kinematics:
    return Kinematics(nao()[0])


@cache
def _reality() -> PlantVariation:
    return load_reality(config_dir() / "realities" / "default.yaml")
