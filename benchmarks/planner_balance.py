"""Loads, friction and torques of planned motions: as planned, and as the physics has them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pages import table
from planner_cases import Case
from planner_outcomes import Job, planner_of, sources_digest, supports
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.simulation.drawn import draw
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import Samples, run
from shoecal_core.workspace import config_dir

FloatArray = NDArray[np.float64]
RATE_HZ = 50.0
HOLD_S = 1.0
_NO_LOAD = 0.01
"""N; less is no load, and no ratio to it is told."""


@dataclass(frozen=True)
class Balance:
    """What one motion needs, each figure by the part of it that is worst.

    Attributes:
        load: least vertical force on a foot that has to keep load, over the weight.
        friction: greatest sideways force over vertical force of such a foot.
        torque: greatest torque of a motor over its limit.
        tilt: greatest tilt of the torso [rad].
    """

    load: float
    friction: float
    torque: float
    tilt: float


@dataclass(frozen=True)
class Simulated:
    """A motion that was planned from measured joint angles and followed in the physics.

    Attributes:
        job: which.
        refused: why there is none; empty where there is.
        planned: as it was planned, by the most probable sharing of the load.
        bound: the same, by the worst sharing within its interval.
        physics: as it was.
    """

    job: Job
    refused: str = ""
    planned: Balance | None = None
    bound: Balance | None = None
    physics: Balance | None = None


def simulated(job: Job) -> Simulated:
    """Place a robot of the default reality, plan, let it follow, look.

    The job's seed draws the double support, its index the robot too.
    """
    case, planner = planner_of(job.robot)
    support = supports(job.robot, job.seed)[job.index]
    if not Feasible(case.robot, planner.settings).can_stand(support):
        return Simulated(job, "the robot cannot be asked to stand there")
    reality = load_reality(config_dir() / "realities" / "default.yaml")
    drawn = draw(reality, case.robot, case.shoe, job.index)
    robot = SimulatedRobot(case.robot, case.shoe, drawn, np.random.default_rng([job.index, 1]))
    try:
        robot.place(planner.stance(support))
        motion = planner.plan_from(robot.joints().angles, job.motion)
        trajectory = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        samples = run(robot, trajectory, RATE_HZ, hold=HOLD_S)
    except ShoecalError as error:
        return Simulated(job, f"{type(error).__name__}: {error}")
    return Simulated(job, "", *_planned(case, motion), _recorded(case, motion, samples))


def _planned(case: Case, motion: Motion) -> tuple[Balance, Balance]:
    robot = case.robot
    shares, loaded = _by_sample(motion)
    body = track(robot, motion.positions, shares)
    tilt = float(np.arccos(np.clip(body.up[:, 2], -1.0, 1.0)).max())
    limit = robot.effort_limit[robot.legs]
    found = []
    for part in (0.0, 1.0):
        load = body.loads - part * body.spread.load[:, None]
        sideways = (body.sideways + part * body.spread.sideways)[:, None]
        torque = np.abs(body.torques) + part * body.spread.torque
        found.append(_balance(load, sideways, loaded, robot.weight, torque / limit, tilt))
    return found[0], found[1]


def _recorded(case: Case, motion: Motion, samples: Samples) -> Balance:
    robot = case.robot
    _, loaded = _by_sample(motion)
    begin = round(HOLD_S * RATE_HZ)
    during = slice(begin, begin + len(motion.time))
    force = samples.truth.foot_force[during]
    x, y = samples.base_orientation[during, :2].T
    tilt = float(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)).max())
    torque = np.abs(samples.joints.efforts[during][:, robot.legs])
    sideways = np.linalg.norm(force[..., :2], axis=-1)
    ratio = torque / robot.effort_limit[robot.legs]
    return _balance(force[..., 2], sideways, loaded, robot.weight, ratio, tilt)


def _by_sample(motion: Motion) -> tuple[FloatArray, NDArray[np.bool_]]:
    """(T, 2) shares as `track` takes them, and (T, 2) whether a foot has to keep load."""
    shares, loaded = np.zeros((len(motion.time), 2)), np.zeros((len(motion.time), 2), dtype=bool)
    for phase in motion.phases:
        during = (motion.time >= phase.begin) & (motion.time <= phase.end)
        shares[during] = phase.support_phase.share
        loaded[during] = np.logical_and(phase.loaded, phase.support_phase.feet)
    return shares, loaded


def _balance(
    load: FloatArray,
    sideways: FloatArray,
    loaded: NDArray[np.bool_],
    weight: float,
    torque: FloatArray,
    tilt: float,
) -> Balance:
    ratio = sideways / np.maximum(load, _NO_LOAD)
    return Balance(
        load=float(load[loaded].min() / weight),
        friction=float(ratio[loaded].max()),
        torque=float(torque.max()),
        tilt=tilt,
    )


class Kept:
    """A file of results, one a line, so that a run which was stopped goes on."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / f"balance-{sources_digest()}.jsonl"
        folder.mkdir(parents=True, exist_ok=True)
        text = self.file.read_text() if self.file.is_file() else ""
        # A run that was killed may have left a part of a line.
        atomic_write(self.file, text[: text.rfind("\n") + 1])

    def known(self) -> dict[Job, Simulated]:
        """All that stand in it."""
        return {one.job: one for one in map(_read, self.file.read_text().splitlines())}

    def add(self, one: Simulated) -> None:
        """Write one more."""
        with self.file.open("a") as file:
            file.write(json.dumps(asdict(one)) + "\n")


def _read(line: str) -> Simulated:
    known = json.loads(line)
    balances = {
        name: None if known[name] is None else Balance(**known[name])
        for name in ("planned", "bound", "physics")
    }
    return Simulated(Job(**known["job"]), known["refused"], **balances)


def beyond(results: Sequence[Simulated]) -> list[str]:
    """Motions of which a figure is beyond its limit, planned or in the physics."""
    found = []
    for one in results:
        friction = Case.named(one.job.robot).robot.friction
        for kind in ("planned", "bound", "physics"):
            figures: Balance | None = getattr(one, kind)
            if figures is None:
                continue
            wrong = [
                name
                for name, kept in (
                    ("load", figures.load >= LIMITS.load_share - _ROUNDING),
                    ("friction", figures.friction <= friction * _BETWEEN_STATES),
                    ("torque", figures.torque <= LIMITS.torque_share * _BETWEEN_STATES),
                    ("tilt", figures.tilt <= LIMITS.tilt_max + _SAG_TILT * (kind == "physics")),
                )
                if not kept
            ]
            found += [f"{one.job}: {kind} {name} of {figures}" for name in wrong]
    return found


LIMITS = PlannerSettings()
_ROUNDING = 0.02
_BETWEEN_STATES = 1.02
"""As the planner's check allows between planned states."""
_SAG_TILT = 0.03
"""rad; by which sagging legs tilt the torso beyond the plan."""

BODY = """\
### Loads, friction and torques, planned and in the physics
Made by `{command}`: {count} motions of the catalogue in turn, in random double supports, each with
another simulated robot of the default reality. *Planned* is by the most probable sharing of the
load, *worst sharing* by the worst one within its interval, *physics* as the simulated floor and
motors had it. Figures are the worst of all motions of a robot. A foot that is to be lifted, or was,
does not count for load and friction.

{rows}

{beyond}

{refused}
"""


def balance_body(command: str, results: Sequence[Simulated]) -> str:
    """The section."""
    rows = [["robot", "motions", "figure", "limit", "planned", "worst sharing", "physics"]]
    for name in dict.fromkeys(one.job.robot for one in results):
        done = [one for one in results if one.job.robot == name and one.physics is not None]
        if not done:
            continue
        friction = Case.named(name).robot.friction
        figures = (
            ("load of a foot over the weight", "load", f"at least {LIMITS.load_share:g}", min),
            ("sideways over vertical force", "friction", f"at most {friction:g}", max),
            ("torque over the motor's limit", "torque", f"at most {LIMITS.torque_share:g}", max),
            ("tilt of the torso [rad]", "tilt", f"at most {LIMITS.tilt_max:g}", max),
        )
        for what, key, limit, worst in figures:
            values = [
                worst(getattr(getattr(one, kind), key) for one in done)
                for kind in ("planned", "bound", "physics")
            ]
            rows.append([name, str(len(done)), what, limit, *(f"{value:.2f}" for value in values)])
    wrong = beyond(results)
    refused = [one for one in results if one.refused]
    return BODY.format(
        command=command,
        count=sum(one.physics is not None for one in results),
        rows=table(rows),
        beyond="\n".join(f"- beyond: {line}" for line in wrong) or "None is beyond its limit.",
        refused=(
            f"Refused before anything moved: {len(refused)} "
            "(double supports in which the robot cannot stand, or not on one foot)."
        ),
    )
