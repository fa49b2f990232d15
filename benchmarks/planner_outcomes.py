"""What becomes of planning in one double support, and a file that remembers it."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import shoecal_core
from planner_cases import Case, Stopwatch
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.posture import StanceSolver, UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.workspace import config_dir

FloatArray = NDArray[np.float64]
PLANNED, REFUSED, FAILED = "planned", "refused", "failed"
FAST = ("Solved", "Applicable")
"""What the fast solver says of its solutions; others are those of IPOPT."""


@dataclass(frozen=True)
class Job:
    """A motion in a double support: the index-th of the robot's range in random order."""

    robot: str
    seed: int
    index: int
    motion: str = "landmarks"


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    Attributes:
        job: which.
        support: dx, dy [m], dtheta [rad].
        end: planned, refused (the robot cannot be asked to stand there) or failed.
        cause: of a failure: the error's name, and what it says.
        wall, cpu: what planning and checking took [s].
        solves, rescues: optimisations, and how many of them were left to IPOPT.
        duration: of the motion [s].
        nearest: how near the CoP came to each place that it was to reach [m].
        standable: indices of those not reached above which the robot can stand.
        violated: constraints that the independent check finds violated.
    """

    job: Job
    support: tuple[float, float, float]
    end: str
    cause: tuple[str, str] = ("", "")
    wall: float = 0.0
    cpu: float = 0.0
    solves: int = 0
    rescues: int = 0
    duration: float = 0.0
    nearest: tuple[float, ...] = ()
    standable: tuple[int, ...] = ()
    violated: tuple[str, ...] = ()

    @classmethod
    def of_json(cls, line: str) -> Outcome:
        known = json.loads(line)
        known["job"] = Job(**known["job"])
        for name in ("support", "cause", "nearest", "standable", "violated"):
            known[name] = tuple(known[name])
        return cls(**known)

    @property
    def unreached(self) -> list[int]:
        """Indices of places that the CoP did not come near enough to."""
        return _beyond_radius(self.nearest)


class Memory:
    """A file of outcomes, one a line, so that a run which was stopped goes on.

    It is valid for the planner and the robots as they are: changed ones begin a new file.
    """

    def __init__(self, folder: Path) -> None:
        self.file = folder / f"outcomes-{_digest()}.jsonl"
        folder.mkdir(parents=True, exist_ok=True)
        text = self.file.read_text() if self.file.is_file() else ""
        # A run that was killed may have left a part of a line.
        atomic_write(self.file, text[: text.rfind("\n") + 1])

    def known(self) -> dict[Job, Outcome]:
        """All that stand in it."""
        lines = self.file.read_text().splitlines()
        return {outcome.job: outcome for outcome in map(Outcome.of_json, lines)}

    def add(self, outcome: Outcome) -> None:
        with self.file.open("a") as file:
            file.write(json.dumps(asdict(outcome)) + "\n")


def attempt(job: Job) -> Outcome:
    """Look whether the robot can stand there, plan, check."""
    case, planner = _planner(job.robot)
    support = supports(job.robot, job.seed)[job.index]
    place = (support.dx, support.dy, support.dtheta)
    if not Feasible(case.robot, planner.settings).can_stand(support):
        return Outcome(job, place, REFUSED)
    watch = Stopwatch()
    try:
        motion = planner.plan(support, job.motion)
    except ShoecalError as error:
        span = watch.read()
        cause = (type(error).__name__, str(error))
        return Outcome(job, place, FAILED, cause, span.wall, span.cpu)
    span = watch.read()
    path = motion.path
    standable = [
        index
        for index in _beyond_radius(path.nearest)
        if _can_stand_above(planner, support, path.targets[index])
    ]
    report = check_motion(planner.legs, motion, planner.settings)
    return Outcome(
        job, place, PLANNED, wall=span.wall, cpu=span.cpu, solves=len(path.statuses),
        rescues=sum(status not in FAST for status in path.statuses), duration=motion.duration,
        nearest=tuple(float(away) for away in path.nearest), standable=tuple(standable),
        violated=tuple(finding.constraint for finding in report.violated),
    )  # fmt: skip


def _beyond_radius(nearest: Iterable[float]) -> list[int]:
    radius = PlannerSettings().landmark_radius
    return [index for index, away in enumerate(nearest) if not away < radius]


def _can_stand_above(planner: Planner, support: DoubleSupport, place: FloatArray) -> bool:
    """Within the margins of standing, which are a little wider than those of moving."""
    try:
        StanceSolver(planner.legs, planner.settings).solve(support, place)
    except UnreachableError:
        return False
    return True


@functools.cache
def supports(robot: str, seed: int) -> list[DoubleSupport]:
    """All of the robot's range whose feet are apart, in random order."""
    case, _ = _planner(robot)
    apart = Feasible(case.robot, PlannerSettings()).apart()
    order = np.random.default_rng(seed).permutation(len(apart))
    return [apart[int(index)] for index in order]


@functools.cache
def _planner(robot: str) -> tuple[Case, Planner]:
    case = Case.named(robot)
    return case, Planner(case.robot, PlannerSettings())


def _digest() -> str:
    """Of everything that outcomes depend on."""
    digest = hashlib.sha256()
    for file in sources():
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def sources() -> Iterator[Path]:
    """Files of the planner, its models and its robots."""
    package = Path(shoecal_core.__file__).parent
    for folder, pattern in (
        (package / "planning", "*.py"),
        (package / "model", "*.py"),
        (config_dir() / "robots", "*"),
        (config_dir() / "shoes", "*"),
    ):
        yield from sorted(file for file in folder.rglob(pattern) if file.is_file())
