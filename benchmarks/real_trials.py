"""Zeros, weight, gains and verdicts over all trials of the REEM-C: a section of
docs/evidence/real-robots.md.

Every trial is held out once: gains are fitted to the others, and the GRF of the trial is predicted
with their mean zeros and with its own.
"""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.calibration.axes import SIDEWAYS, sideways_axes
from shoecal_core.calibration.pipeline import Outcome, calibrate_session
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.estimation.weight import Weighed, weigh
from shoecal_core.recording.session import Session
from shoecal_core.samples.zeros import NORMAL_95, data_sheet
from shoecal_core.sensing.shoe import FEET

SHOWN = ("left/fx", "left/fy", "left/fz", "left/mx", "left/my",
         "right/fx", "right/fy", "right/fz", "right/mx", "right/my")  # fmt: skip
NUMBERS = (1, 3, 4)
"""Trials that gains are fitted to, besides all."""


def section(session: Session, settings: CalibrationSettings) -> str:
    """The section in Markdown."""
    runs = [entry.run for entry in session.runs]
    names = {entry.run: f"{entry.run} {entry.info.motion}" for entry in session.runs}
    held = {run: _held_out(session, settings, run, runs) for run in runs}
    growing = {
        count: calibrate_session(session, runs[:count], settings=settings, rezero=True)
        for count in (*NUMBERS, len(runs))
    }
    everything = growing[len(runs)]
    weighed = everything.data.weighed
    assert weighed is not None
    low, high = weighed.ci95
    weights = {
        run: weigh(session.shoe, {run: session.read(run).readings.value}, everything.data.zeros)
        for run in runs
    }
    return SECTION.format(
        count=len(runs),
        zeros="\n".join(_zero_row(run, names, held[run], everything, weights[run]) for run in runs),
        weight=f"{weighed.kg:.1f} kg (95 %: {low:.1f} to {high:.1f} kg)",
        file=f"{everything.data.robot.mass:.1f} kg",
        header=" | ".join(f"{count} trials" for count in growing),
        rule="|".join("---" for _ in growing),
        gains="\n".join(_gain_row(name, list(growing.values())) for name in SHOWN),
        errors="\n".join(_error_row(run, names, held[run]) for run in runs),
        axes="\n".join(_axis_rows(everything, runs)),
    )


def _held_out(
    session: Session, settings: CalibrationSettings, run: int, runs: Sequence[int]
) -> tuple[Outcome, Outcome]:
    """Judged with the mean zeros of the others, and with its own."""
    train = [other for other in runs if other != run]
    one_set, own = (
        calibrate_session(session, train, (run,), settings, rezero=rezero)
        for rezero in (False, True)
    )
    return one_set, own


def _zero_row(
    run: int,
    names: dict[int, str],
    held: tuple[Outcome, Outcome],
    everything: Outcome,
    weighed: Weighed | None,
) -> str:
    data = everything.data
    cells = [names[run]]
    for foot in range(len(FEET)):
        law = data_sheet(data.shoe, foot)
        (zero,) = [one for one in data.zeros if (one.run, one.foot) == (run, foot)]
        assert law is not None
        shown = zero.wrench(data.shoe, law)[:, 0]
        force, std = zero.force(data.shoe, law)
        swings = [shown[zero.phase == one].mean() - force for one in range(zero.phase.max() + 1)]
        cells.append(f"{force:.1f} ± {NORMAL_95 * std:.1f}")
        cells.append(f"{min(swings):+.1f} to {max(swings):+.1f}")
        others = held[0].calibration.parameters
        cells.append(f"{zero.force(data.shoe, others)[0]:+.1f}")
    cells.append("-" if weighed is None else f"{weighed.kg:.2f}")
    return f"| {' | '.join(cells)} |"


def _gain_row(name: str, outcomes: Sequence[Outcome]) -> str:
    cells = []
    for outcome in outcomes:
        index = outcome.data.shoe.index(name)
        gain = outcome.calibration.parameters.gain[index]
        half = NORMAL_95 * float(outcome.assessment.covariance[index, index]) ** 0.5
        cells.append(f"{gain:.2f} ± {half:.2f}")
    return f"| {name} | {' | '.join(cells)} |"


def _error_row(run: int, names: dict[int, str], held: tuple[Outcome, Outcome]) -> str:
    cells = [names[run]]
    for outcome in held:
        error = outcome.modelled["self_calibration"]["test"]
        cells += [f"{error.grf.mean:.1f}", outcome.calibration.verdict]
    own = held[1]
    error, limit = own.modelled["self_calibration"]["test"], own.limits["test"]
    left, right = (1e3 * one.mean for one in error.foot_cop)
    cells += [f"{1e3 * error.cop.mean:.0f} ({left:.0f}, {right:.0f})", f"{1e3 * limit.cop[0]:.0f}"]
    cells.append(f"{limit.together[0]:.2f}")
    return f"| {' | '.join(cells)} |"


def _axis_rows(outcome: Outcome, runs: Sequence[int]) -> list[str]:
    return [
        f"| {FEET[one.foot]}/{name} "
        f"| {one.slope[index, index]:+.2f} ± {one.half[index, index]:.2f} "
        f"| {'reversed' if name in one.reversed else 'open'} |"
        for one in sideways_axes(outcome.data.shoe, outcome.data.of(runs))
        for index, name in enumerate(SIDEWAYS)
    ]


SECTION = """\
### All {count} trials: zeros, weight, gains, verdicts

Zeros: vertical force that a foot shows in the air, 95 % interval; how far single swings are off it;
and what is left of it by the mean zeros of the other trials (N). Weight: by the data sheets of the
sensors, from the mean of the whole trial.

| trial | left zero | its swings | others leave | right zero | its swings | others leave | kg |
|---|---|---|---|---|---|---|---|
{zeros}

All trials together weigh the robot at {weight}; its URDF says {file}. Only a scale can decide.

Gains over data sheets (all 1), fitted to the first 1, 3, 4 and all trials, 95 % interval:

| channel | {header} |
|---|{rule}|
{gains}

Each trial held out once, fitted to all others: GRF with one set of offsets and with the trial's own
zeros (`--rezero`), with the verdicts; CoP with own zeros (left, right foot alone); what the best
scale and shift of the CoP would leave, and how far sensor and model move together within steps (r):

| held out | GRF, one set | verdict | GRF, own zeros | verdict | CoP (mm) | at best (mm) | r |
|---|---|---|---|---|---|---|---|
{errors}

Slopes of the sideways axes on mass times acceleration in single supports (+1 if parallel), mean and
95 % interval over trials:

| channel | slope | finding |
|---|---|---|
{axes}

"""
