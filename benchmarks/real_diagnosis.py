"""What `diagnose` says of the REEM-C's three trials: a section of docs/evidence/real-robots.md.

Each trial is held out once. The sensors' axes are not documented, so they are read in two ways:
all parallel to the sole's, and with both sideways forces the other way round.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import Cause, Diagnosis
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.model.robot_file import load_robot
from shoecal_core.recording.csv_import import import_csv
from shoecal_core.recording.session import Session
from shoecal_core.samples.aligned import align
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.walking import in_world, walking_stances
from shoecal_core.sensing.shoe import FEET

FloatArray = NDArray[np.float64]
CONFIG = Path(__file__).resolve().parents[1] / "config"
SIDEWAYS = ("fx", "fy")
JUDGED = slice(0, 3)
"""Signals that errors are told of: GRF and both axes of the CoP."""
SHOWN = 3


@dataclass(frozen=True)
class Split:
    """One trial held out, and what was made of it."""

    axes: str
    diagnosis: Diagnosis

    @property
    def error_before(self) -> tuple[float, float]:
        """CoP [mm] and GRF [N] of the held-out trial with nothing added."""
        return self._errors(explained=False)

    @property
    def error_after(self) -> tuple[float, float]:
        """The same with what was found."""
        return self._errors(explained=True)

    @property
    def excess(self) -> tuple[float, float]:
        """Mean square of GRF and CoP errors in noises, less 1, before and after."""
        first, second = (
            float(np.nanmean((rest[:, JUDGED] / self._noise[JUDGED]) ** 2)) - 1.0
            for rest in (self._rest(explained=False), self._rest(explained=True))
        )
        return first, second

    @property
    def _noise(self) -> FloatArray:
        assert self.diagnosis.evidence is not None
        return self.diagnosis.evidence.noise

    def _rest(self, *, explained: bool) -> FloatArray:
        evidence = self.diagnosis.evidence
        assert evidence is not None
        fitted = evidence.explained if explained and evidence.explained else evidence.without
        return fitted.residuals[evidence.test]

    def _errors(self, *, explained: bool) -> tuple[float, float]:
        rest = self._rest(explained=explained)
        return (
            1e3 * float(np.nanmean(np.linalg.norm(rest[:, 1:3], axis=1))),
            float(np.nanmean(np.abs(rest[:, 0]))),
        )


def sessions(recordings: Path, folder: Path) -> dict[str, Session]:
    """The recordings with the axes read in both ways, as sessions in a folder."""
    config = folder / "config"
    shutil.copytree(CONFIG, config)
    shoe = config / "shoes" / "reemc.yaml"
    found = {"parallel": import_csv(config / "imports" / "reemc.yaml", recordings, folder / "a")}
    text = shoe.read_text()
    for axis in SIDEWAYS:
        text = text.replace(f"{{axis: {axis}, polarity: 1", f"{{axis: {axis}, polarity: -1")
    shoe.write_text(text)
    found["reversed"] = import_csv(config / "imports" / "reemc.yaml", recordings, folder / "b")
    return found


def section(
    recordings: Path,
    folder: Path,
    splits: Sequence[tuple[tuple[int, ...], int]],
    trials: dict[int, str],
) -> str:
    """The section in Markdown."""
    read = sessions(recordings, folder)
    found = [
        Split(axes, diagnose(session, train, (test,)))
        for axes, session in read.items()
        for train, test in splits
    ]
    return SECTION.format(
        zeros="\n".join(_zeros(read["parallel"], trials)),
        pushes="\n".join(_pushes(read["parallel"], trials)),
        errors="\n".join(_error_row(split, trials) for split in found),
        causes="\n".join(_cause_row(split, trials) for split in found),
        notes="\n".join(f"- {note}" for note in found[0].diagnosis.notes),
    )


def _error_row(split: Split, trials: dict[int, str]) -> str:
    diagnosis = split.diagnosis
    (cop, grf), (cop_after, grf_after) = split.error_before, split.error_after
    over, left = split.excess
    cells = (
        split.axes,
        trials[diagnosis.test[0]],
        diagnosis.verdict,
        f"{grf:.1f} → {grf_after:.1f}",
        f"{cop:.1f} → {cop_after:.1f}",
        f"{diagnosis.gap.cop_floor_mm:.1f}",
        f"{over:.1f} → {left:.1f}",
    )
    return f"| {' | '.join(cells)} |"


def _cause_row(split: Split, trials: dict[int, str]) -> str:
    diagnosis = split.diagnosis
    rivals = ", ".join(f"{one.label} {one.probability:.2f}" for one in diagnosis.ambiguity[:SHOWN])
    cells = (
        split.axes,
        trials[diagnosis.test[0]],
        "; ".join(_cause(cause) for cause in diagnosis.causes) or "none",
        rivals or "none",
    )
    return f"| {' | '.join(cells)} |"


def _cause(cause: Cause) -> str:
    sizes = ", ".join(
        f"{name} {size.value:.3g} [{size.ci95[0]:.3g}, {size.ci95[1]:.3g}] {size.unit}".strip()
        for name, size in cause.size.items()
    )
    return f"{cause.label}: {sizes}"


def _single(session: Session) -> Iterator[tuple[int, int, Stance, FloatArray]]:
    """Run, standing foot and stance of each single support, with the push (T, 2) that the CoM's
    acceleration asks of the floor along the sole's x and y [N]."""
    robot = load_robot(session.robot_yaml, session.shoe, urdf=session.robot_urdf)
    kinematics = Kinematics(robot)
    for entry in session.runs:
        run = session.read(entry.run)
        aligned = align(run, session.shoe, kinematics)
        assert run.base_pose is not None
        world = in_world(aligned, run.base_pose, robot)
        for stance in walking_stances(run.info.run, aligned, world, session.shoe, robot):
            if not all(stance.loaded):
                foot = stance.loaded.index(True)
                here = np.searchsorted(aligned.time, stance.time)
                c, s = np.cos(world.yaw[here, foot]), np.sin(world.yaw[here, foot])
                x, y = world.acceleration[here, :2].T
                push = robot.mass * np.stack((c * x + s * y, -s * x + c * y), axis=1)
                yield run.info.run, foot, stance, push


def _zeros(session: Session, trials: dict[int, str]) -> Iterator[str]:
    """What the vertical channels show of a foot in the air, and of one that stands alone."""
    vertical = [session.shoe.names.index(f"{foot}/fz") for foot in FEET]
    single = list(_single(session))
    for run, trial in trials.items():
        here = [(foot, stance) for number, foot, stance, _ in single if number == run]
        hangs, stands = (
            [
                float(np.mean(np.concatenate(
                    [one.readings[:, vertical[foot]] for at, one in here if (at == foot) == stands]
                )))
                for foot in (0, 1)
            ]
            for stands in (False, True)
        )  # fmt: skip
        cells = [trial, *(f"{value:.0f}" for value in hangs)]
        cells += [f"{above - zero:.0f}" for above, zero in zip(stands, hangs, strict=True)]
        yield f"| {' | '.join(cells)} |"


def _pushes(session: Session, trials: dict[int, str]) -> Iterator[str]:
    """Slopes of the sideways channels on mass times acceleration, walking in single support."""
    single = list(_single(session))
    for run, trial in trials.items():
        cells = [trial]
        for foot in (0, 1):
            parts = [(one, push) for number, at, one, push in single if (number, at) == (run, foot)]
            for axis, name in enumerate(SIDEWAYS):
                channel = session.shoe.names.index(f"{FEET[foot]}/{name}")
                told = np.concatenate([one.readings[:, channel] for one, _ in parts])
                push = np.concatenate([push[:, axis] for _, push in parts])
                slope = float(np.cov(told, push)[0, 1] / np.var(push))
                cells.append(f"{slope:+.2f} (r {np.corrcoef(told, push)[0, 1]:+.2f})")
        yield f"| {' | '.join(cells)} |"


SECTION = """\
### Why they differ: the diagnosis

One split by hand: `shoecal diagnose out/reemc --train 1,2 --test 3 --no-simulation`. Each step
counts as one sample; expected are m (g + a_z) and the zero-moment point of a single mass. Notes
of the diagnosis:

{notes}

**Zeros and gains, without a model.** A foot in the air shows its weight below the sensor and the
sensor's zero; a foot that stands alone shows the robot's weight in addition (`fz`, means over all
single supports, N):

| trial | left hangs | right hangs | left alone, above that | right alone, above that |
|---|---|---|---|---|
{zeros}

The zeros change between trials by some tens of newtons, so one set of offsets cannot fit all
three; and the right sensor shows more than the left for the same robot.

**Sideways forces.** On one foot the floor's sideways force is the mass times the CoM's
acceleration. Slope of each sideways channel on it (1 for axes parallel to the sole's; r is the
correlation):

| trial | left fx | left fy | right fx | right fy |
|---|---|---|---|---|
{pushes}

In the walks `fy` is opposite to the force on both feet; `fx` is inconclusive. So both readings are
tested: axes *parallel* to the sole's, and *reversed* (polarity of `fx` and `fy` -1).

**Held-out trials.** Mean errors over the steps of the held-out trial, without → with the found
causes; excess is the mean square of GRF and CoP errors in units of the noise, less 1:

| axes | held out | verdict | GRF (N) | CoP (mm) | CoP floor (mm) | excess |
|---|---|---|---|---|---|---|
{errors}

| axes | held out | causes chosen (95 % interval) | most probable last causes |
|---|---|---|---|
{causes}

Interpretation:
- With parallel axes nothing known explains the residual. With reversed sideways axes it is smaller
  from the start, and the slopes of `fy` agree. So the axes are probably reversed: `polarity: -1`
  for `fx` and `fy`.
- The remaining CoP residual alternates: left in every step on the left foot, right on the right,
  constant over the trial. Its cause is fixed to the feet: a foot or sensor position, or, nearly
  indistinguishable in walking, tilted soles or encoders of the ankle rolls.
- GRF does not improve: the zeros change from trial to trial, and a diagnosis uses one set of
  offsets. With each trial's own zeros it does (above).
- The stepping trial cannot be predicted from the walks, probably because they have almost no double
  support with shared load.

Not blind: one sample per step, and reversing both sideways axes together, were decided while
looking at all three trials. Within a row, fit and causes have seen only the two training trials.

"""
