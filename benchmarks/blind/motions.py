"""Planned motions of the thorough set, kept on the disk: planning costs more than simulating."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from blind.layout import POOL
from blind.processes import over
from population import nao
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.planning.motion_sets import STANDARD_SUPPORTS, THOROUGH, PlannedRun, set_runs
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory


@dataclass(frozen=True)
class PlannedMotion:
    """A motion, ready to be followed.

    Attributes:
        run: which motion in which double support, what for.
        trajectory: of all joints.
    """

    run: PlannedRun
    trajectory: JointTrajectory

    def paced(self, factor: float) -> PlannedMotion:
        """The same, so many times as fast."""
        told = self.trajectory
        faster = JointTrajectory(told.names, told.times / factor, told.positions)
        return dataclasses.replace(self, trajectory=faster)


def planned_set(seed: int) -> tuple[PlannedMotion, ...]:
    """The thorough set of motions in double supports that a seed draws; planned once."""
    file = _file(f"{seed:04d}")
    if not file.is_file():
        _keep(file, [_planned(run) for run in _runs(seed)])
    return _kept(file)


def fill(seeds: Sequence[int], jobs: int) -> list[int]:
    """Plan what is missing of several sets; the seeds that have one."""
    there = over(_there, seeds, jobs)
    return [seed for seed, can in zip(seeds, there, strict=True) if can]


def _there(seed: int) -> bool:
    """Whether a seed's motions could be planned."""
    try:
        planned_set(seed)
    except ShoecalError as error:
        print(f"motions {seed}: {error}", flush=True)
        return False
    return True


def _runs(seed: int) -> tuple[PlannedRun, ...]:
    robot, shoe = nao()
    supports = draw_supports(robot, shoe, PlannerSettings(), STANDARD_SUPPORTS, seed)
    mixed = [supports[i] for i in np.random.default_rng(seed).permutation(5)]
    return set_runs(THOROUGH, mixed, robot.neutral)


@cache
def _planner() -> Planner:
    return Planner(nao()[0], PlannerSettings())


def _planned(run: PlannedRun) -> PlannedMotion:
    motion = _planner().plan(run.support, run.motion)
    return PlannedMotion(run, JointTrajectory(motion.joint_names, motion.time, motion.positions))


def _file(name: str) -> Path:
    """Of motions; another robot or shoe has others."""
    robot, shoe = nao()
    return POOL / f"{THOROUGH}_{robot.digest[:8]}_{shoe.digest[:8]}" / f"{name}.npz"


def _keep(file: Path, motions: Sequence[PlannedMotion]) -> None:
    arrays: dict[str, NDArray[np.generic]] = {}
    for index, one in enumerate(motions):
        support = one.run.support
        arrays[f"{index}_about"] = np.array([one.run.motion, one.run.hint])
        arrays[f"{index}_support"] = np.array([support.dx, support.dy, support.dtheta])
        arrays[f"{index}_time"] = one.trajectory.times
        arrays[f"{index}_positions"] = one.trajectory.positions
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]  # none is its `allow_pickle`
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, buffer.getvalue())


def _kept(file: Path) -> tuple[PlannedMotion, ...]:
    names = nao()[0].joint_names
    motions = []
    with np.load(file) as kept:
        for index in range(sum(name.endswith("_about") for name in kept.files)):
            motion, hint = map(str, kept[f"{index}_about"])
            support = DoubleSupport(*map(float, kept[f"{index}_support"]))
            trajectory = JointTrajectory(names, kept[f"{index}_time"], kept[f"{index}_positions"])
            motions.append(PlannedMotion(PlannedRun(support, motion, hint), trajectory))
    return tuple(motions)
