"""Everything known of the same instants side by side: guess, calibration, model, truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import (
    Errors,
    Series,
    errors,
    measured_series,
    modelled_series,
    truth_series,
)
from shoecal_core.estimation.session_data import SessionData
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import Truth, read_truth
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.sensing import Sensing


@dataclass(frozen=True)
class StanceComparison:
    """One stance.

    Attributes:
        set: `train` or `test`.
        stance: the samples.
        guess: measured with the initial guess.
        measured: measured with the calibration.
        modelled: expected by the model.
        truth: as the simulator knows it; None where there is none.
    """

    set: str
    stance: Stance
    guess: Series
    measured: Series
    modelled: Series
    truth: Series | None

    @property
    def reference(self) -> Series:
        """The best that is known: the truth, else the model."""
        return self.modelled if self.truth is None else self.truth


def read_truths(session: Session, data: SessionData) -> dict[int, Truth]:
    """Truth of the runs that have one (only simulated ones do)."""
    return {
        run: read_truth(session.truth_path(run), recorded.start_ns)
        for run, recorded in data.runs.items()
        if session.truth_path(run).is_file()
    }


def compare(outcome: CalibrationOutcome, truths: Mapping[int, Truth]) -> list[StanceComparison]:
    """Every stance of every run, training runs first."""
    guessed = Sensing(outcome.data.shoe, outcome.stages.guess.parameters)
    return [
        StanceComparison(
            set=name,
            stance=stance,
            guess=measured_series(guessed, stance),
            measured=measured_series(outcome.stages.sensing, stance),
            modelled=modelled_series(stance),
            truth=truth_series(truths[stance.run], stance) if stance.run in truths else None,
        )
        for name, runs in (("train", outcome.train), ("test", outcome.test))
        for stance in outcome.data.of(runs)
    ]


def stage_errors(comparisons: Sequence[StanceComparison]) -> dict[str, dict[str, Errors]]:
    """Errors against the reference by stage (`modelled` too, where there is a truth) and set."""
    stages = ["initial_guess", "self_calibration"]
    if all(one.truth is not None for one in comparisons):
        stages.insert(0, "modelled")
    fields = {"modelled": "modelled", "initial_guess": "guess", "self_calibration": "measured"}
    found: dict[str, dict[str, Errors]] = {}
    for stage in stages:
        for name in ("train", "test"):
            pairs: list[tuple[Series, Series]] = [
                (getattr(one, fields[stage]), one.reference)
                for one in comparisons
                if one.set == name
            ]
            if pairs:
                found.setdefault(stage, {})[name] = errors(pairs)
    return found
