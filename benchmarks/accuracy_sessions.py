"""Simulated sessions of `accuracy.py`: made once, kept, and made anew where their inputs change.

They are in out/accuracy/MOTIONS/REALITY/seed_NNN. A seed draws the robot, its cells, the double
supports and the noise; the robot and its double supports are the same in every reality.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml

from population import ROOT, SUPPORTS, TRAIN, make_session, nao, paper_runs
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write, sha256
from shoecal_core.planning.motion_sets import STANDARD, STANDARD_SUPPORTS, set_runs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.recording.session import Session
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.many_jobs import over_cores
from shoecal_core.workspace import config_dir

OUT = ROOT / "out" / "accuracy"
DEFAULT = "default"
NOISY = ("noisy", "noisy_1n")
"""The default reality in all but the noise of its readings."""
REALITIES = (DEFAULT, "other_laws", "as_stated", *NOISY)
PAPER = "paper"
MOTIONS = (STANDARD, PAPER)
"""The set that a self-calibration records by default, with both unloading motions, and the paper's
own protocol."""


@dataclass(frozen=True)
class Case:
    """One session.

    Attributes:
        reality: name of its file in config/realities.
        motions: one of MOTIONS.
        seed: of everything that is drawn.
        out: folder of all sessions.
        manual: a manual calibration of its shoes is the prior.
    """

    reality: str
    motions: str
    seed: int
    out: Path = OUT
    manual: bool = False

    @property
    def folder(self) -> Path:
        """Where the session is."""
        return self.out / self.motions / self.reality / f"seed_{self.seed:03d}"

    @property
    def changes(self) -> Path | None:
        """Its reality file; None for the default one."""
        file = config_dir() / "realities" / f"{self.reality}.yaml"
        return None if self.reality == DEFAULT else file

    @property
    def takes_manual(self) -> bool:
        """Whether it is calibrated with a manual calibration, too."""
        return (self.motions, self.reality) == (STANDARD, DEFAULT)

    def load_reality(self) -> PlantVariation:
        """What its reality file says."""
        return load_reality(config_dir() / "realities" / "default.yaml", self.changes)

    @property
    def quiet(self) -> Case:
        """The same motions of the same robot, read without the noise."""
        return replace(self, reality=DEFAULT) if self.reality in NOISY else self

    def sets(self, session: Session) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Runs to train and to test: as recorded, or drawn as the paper draws three of five."""
        runs = [entry.run for entry in session.runs]
        if self.motions == PAPER:
            drawn = np.random.default_rng([self.seed, 3]).permutation(SUPPORTS)[:TRAIN] + 1
            train = set(drawn.tolist())
        else:
            train = {entry.run for entry in session.runs if entry.hint == "train"}
        return tuple(run for run in runs if run in train), tuple(
            run for run in runs if run not in train
        )

    @property
    def inputs(self) -> str:
        """Hash of what the files say that it is made from; their comments do not count."""
        robot, shoe = nao()
        files = [robot.path, shoe.path, config_dir() / "realities" / "default.yaml", self.changes]
        said = [yaml.safe_load(file.read_text()) for file in files if file is not None]
        text = json.dumps([sha256(robot.urdf), *said], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def made(self) -> bool:
        """Whether the session is there, made from today's inputs."""
        return (
            self.folder.is_dir()
            and self._mark.is_file()
            and self._mark.read_text() == (self.inputs)
        )

    @property
    def failed(self) -> str:
        """Why it cannot be recorded from today's inputs; empty when it can, or was not tried."""
        note = self._mark.with_suffix(".failed")
        inputs, _, why = note.read_text().partition("\n") if note.is_file() else ("", "", "")
        return why if inputs == self.inputs else ""

    @property
    def _mark(self) -> Path:
        return self.folder.with_suffix(".inputs")

    def make(self) -> None:
        """Simulate it."""
        robot, shoe = nao()
        standard = self.motions == STANDARD
        count = STANDARD_SUPPORTS if standard else SUPPORTS
        shutil.rmtree(self.folder, ignore_errors=True)
        try:
            supports = draw_supports(robot, shoe, PlannerSettings(), count, self.seed)
            runs = set_runs(STANDARD, supports, robot.neutral) if standard else paper_runs(supports)
            make_session(
                self.folder, runs, seed=self.seed, robot_seed=self.seed, reality=self.changes
            )
        except ShoecalError as error:
            # For instance no double support in which it can stand on one foot alone.
            atomic_write(self._mark.with_suffix(".failed"), f"{self.inputs}\n{error}")
            return
        atomic_write(self._mark, self.inputs)


def cases(
    realities: Sequence[str], motions: Sequence[str], seeds: Sequence[int], out: Path = OUT
) -> list[Case]:
    """All of them, seed by seed."""
    return [
        Case(reality, motion, seed, out)
        for seed in seeds
        for motion in motions
        for reality in realities
    ]


def make(wanted: Sequence[Case], jobs: int) -> None:
    """Make those that are missing, and those that they are judged on."""
    needed = dict.fromkeys(one for case in wanted for one in (case, case.quiet))
    missing = [case for case in needed if not case.made and not case.failed]
    if not missing:
        return
    for done, (number, seconds) in enumerate(over_cores(_make, missing, jobs), start=1):
        case = missing[number]
        end = "not to be had: " + case.failed if case.failed else f"{seconds:.0f} s"
        print(f"{case.folder.relative_to(case.out)}: {end} ({done} of {len(missing)})", flush=True)


def _make(case: Case) -> float:
    begin = time.perf_counter()
    case.make()
    return time.perf_counter() - begin
