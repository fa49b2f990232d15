"""What a diagnosis says, as data: for programs (`to_json`), reports and whatever acts on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.samples.zeros import Zero

FORMAT = 1

Verdict = Literal["no_gap", "explained", "ambiguous", "partly_explained", "unknown"]
VERDICT_TEXTS: Mapping[Verdict, str] = {
    "no_gap": "model and reality agree as closely as they do on a robot within its tolerances",
    "explained": "one explanation accounts for the gap",
    "ambiguous": "several explanations account for the gap alike",
    "partly_explained": "what was found explains a part of the gap; something is left",
    "unknown": "there is a gap, and nothing in the library explains it",
}
"""What each verdict means."""


@dataclass(frozen=True)
class Gap:
    """How far model and measurement are apart on the test runs, with nothing added.

    Attributes:
        cop_mae_mm, grf_mae_n: mean errors against the model [mm, N].
        cop_floor_mm, grf_floor_n: what noise and errors within tolerance would leave [mm, N].
    """

    cop_mae_mm: float
    grf_mae_n: float
    cop_floor_mm: float
    grf_floor_n: float


@dataclass(frozen=True)
class Where:
    """A place in signal, body and time that holds a share of the gap.

    Attributes:
        signal: grf, cop_x, cop_y, closure, parity, air or tilt.
        foot, cell, joint, run, phase: None where it is not particular.
        onset_s: when it starts, since the run's start [s]; None where it is always there.
        share: of the whole excess, 0 to 1.
    """

    signal: str
    foot: str | None
    cell: str | None
    joint: str | None
    run: int | None
    phase: str | None
    onset_s: float | None
    share: float


@dataclass(frozen=True)
class Size:
    """One component of an effect's size: value and 95 % interval in its unit."""

    value: float
    unit: str
    ci95: tuple[float, float]


@dataclass(frozen=True)
class Shrink:
    """How far the gap shrinks with an effect in the model, on runs that no fit has seen.

    Attributes:
        fraction: 1 - excess with / excess without (diagnosis.md: noise-whitened).
        ci95: its 95 % interval.
        cop_mae_mm, grf_mae_n: before and after [mm, N].
    """

    fraction: float
    ci95: tuple[float, float]
    cop_mae_mm: tuple[float, float]
    grf_mae_n: tuple[float, float]


@dataclass(frozen=True)
class SimulatedShrink:
    """The same between the recording and a simulated robot that has the effect.

    Attributes:
        fraction: of the squares of the mean errors of CoP and GRF, together.
        cop_mae_mm, grf_mae_n: before and after [mm, N].
    """

    fraction: float
    cop_mae_mm: tuple[float, float]
    grf_mae_n: tuple[float, float]


@dataclass(frozen=True)
class NamedHypothesis:
    """An effect at a place, and how probable it is."""

    effect: str
    location: tuple[str, ...]
    probability: float

    @property
    def label(self) -> str:
        """For a person to read."""
        return f"{self.effect} ({', '.join(self.location)})" if self.location else self.effect


@dataclass(frozen=True)
class Cause:
    """One effect of the explanation that was chosen.

    Attributes:
        effect, group: identifier and class.
        location: cells, feet, joints or links; `all`; empty where it has no place.
        probability: that it is there.
        size: by component.
        run: number of the run that it happens in; None for an effect that is always there.
        shrink: with it, on runs never used.
        simulated: the same with it in the simulator; None where that was not run.
        hidden_cop_mm: how much of its CoP error a calibration would absorb, so that it would
            not show in its residuals [mm].
    """

    effect: str
    group: str
    location: tuple[str, ...]
    probability: float
    size: Mapping[str, Size]
    run: int | None
    shrink: Shrink
    hidden_cop_mm: float
    simulated: SimulatedShrink | None = None

    @property
    def label(self) -> str:
        """For a person to read."""
        return NamedHypothesis(self.effect, self.location, self.probability).label


@dataclass(frozen=True)
class Action:
    """What to do about it.

    Attributes:
        do: in words.
        expected_cop_mm: mean error of the CoP on test runs before and after [mm].
    """

    do: str
    expected_cop_mm: tuple[float, float]


@dataclass(frozen=True)
class BudgetShare:
    """What one source holds of the CoP's gap.

    Attributes:
        source: an effect, as a cause or as a tolerance error; or `other errors as built`, or
            `not explained`.
        location: its place; empty for all places together.
        cop_share: of the mean square on the test runs; negative where it works against others.
        ci95: its 95 % interval.
    """

    source: str
    location: tuple[str, ...]
    cop_share: float
    ci95: tuple[float, float]

    @property
    def label(self) -> str:
        """For a person to read."""
        return NamedHypothesis(self.source, self.location, 0.0).label


@dataclass(frozen=True)
class NextMotion:
    """The run that would best separate what is still confused.

    Attributes:
        motion: name in the catalogue.
        separates: the labels of what it separates.
    """

    motion: str
    separates: tuple[str, ...]


@dataclass(frozen=True)
class Fitted:
    """The same runs with one explanation in the model, for pictures.

    Attributes:
        label: of the explanation.
        residuals: (T, s) signals measured minus modelled, NaN where a signal is not there.
        contribution: (T, s) what the explanation adds to the signals.
    """

    label: str
    residuals: FloatArray
    contribution: FloatArray


@dataclass(frozen=True)
class Evidence:
    """What pictures are drawn from: T samples in time, s signals.

    Attributes:
        signals: names: grf [N]; cop_x, cop_y [m]; air_f [N], air_mx, air_my [N m]; closure_x,
            _y, _z [m], _roll, _pitch, _yaw [rad]; parity_left, parity_right [N]; tilt_x,
            tilt_y [rad].
        run: (T,) numbers. time: (T,) since the run's start [s].
        test: (T,) samples of test runs.
        loaded: (T, 2) feet that carry load.
        support: (T, 3) right sole in the left sole's frame: x, y [m], yaw [rad].
        cop: (T, 2) modelled CoP in the frame of the stance: the left sole's, or the right
            sole's while the left foot hangs; cop_x and cop_y are in it too [m].
        foot_cop: (T, 2, 2) measured one of each foot in its sole frame, NaN unloaded [m];
            foot_force: (T, 2) [N].
        outputs: (T, n) of the channels [N or N m].
        noise: (s,) standard deviation of each signal's noise.
        without: with nothing added.
        explained: with what was found; None where nothing was.
        rivals: with each of the most probable hypotheses alone, the best first.
    """

    signals: tuple[str, ...]
    run: IntArray
    time: FloatArray
    test: BoolArray
    loaded: BoolArray
    support: FloatArray
    cop: FloatArray
    foot_cop: FloatArray
    foot_force: FloatArray
    outputs: FloatArray
    noise: FloatArray
    without: Fitted
    explained: Fitted | None
    rivals: tuple[Fitted, ...]


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer.

    Attributes:
        verdict: see VERDICT_TEXTS.
        gap: on the test runs.
        where: the largest shares first.
        causes: the explanation chosen, largest share first; empty for no_gap and unknown.
        ambiguity: what cannot be separated from the first cause, itself included; empty
            without a cause.
        ranking: all hypotheses that matter, the most probable first.
        cannot_detect: what this session could not show, in words.
        cannot_separate: sets of labels that cannot be separated in this session.
        next_motion: None where nothing is confused, or no motion would separate it.
        train, test: numbers of the runs.
        notes: what was missing or left out, in words.
        robot, shoe: names.
        shrink: with all causes together, from nothing added; None where it was not measured.
        evidence: for pictures; None where it was not kept.
        action: what to do first.
        dissent: what speaks against the causes, or spoke against others, in words.
        zeros: what feet in the air show, run by run.
        budget: what the CoP's gap is made of, the largest first.
    """

    verdict: Verdict
    gap: Gap
    where: tuple[Where, ...]
    causes: tuple[Cause, ...]
    ambiguity: tuple[NamedHypothesis, ...]
    ranking: tuple[NamedHypothesis, ...]
    cannot_detect: tuple[str, ...]
    cannot_separate: tuple[tuple[str, ...], ...]
    next_motion: NextMotion | None
    train: tuple[int, ...]
    test: tuple[int, ...]
    notes: tuple[str, ...]
    robot: str
    shoe: str
    shrink: Shrink | None = None
    evidence: Evidence | None = field(default=None, repr=False, compare=False)
    action: Action | None = None
    dissent: tuple[str, ...] = ()
    zeros: tuple[Zero, ...] = field(default=(), repr=False, compare=False)
    budget: tuple[BudgetShare, ...] = ()

    @property
    def named(self) -> tuple[Cause, ...]:
        """Causes without those that somebody asked for and nothing confirms."""
        return () if self.verdict in ("no_gap", "unknown") else self.causes

    def to_json(self) -> dict[str, object]:
        """The public form (`shoecal diagnose --json`)."""
        return {
            "format": FORMAT,
            "verdict": self.verdict,
            "robot": self.robot,
            "shoe": self.shoe,
            "train": list(self.train),
            "test": list(self.test),
            "gap": vars(self.gap).copy(),
            "where": [vars(place).copy() for place in self.where],
            "shrink": None if self.shrink is None else _pairs(vars(self.shrink)),
            "causes": [_cause(cause) for cause in self.causes],
            "ambiguity_set": [_hypothesis(one) for one in self.ambiguity],
            "action": None if self.action is None else _pairs(vars(self.action)),
            "dissent": list(self.dissent),
            "budget": [_pairs(vars(one)) for one in self.budget],
            "ranking": [_hypothesis(one) for one in self.ranking],
            "cannot_detect": list(self.cannot_detect),
            "cannot_separate": [list(names) for names in self.cannot_separate],
            "next_motion": None
            if self.next_motion is None
            else {
                "motion": self.next_motion.motion,
                "separates": list(self.next_motion.separates),
            },
            "notes": list(self.notes),
        }


def _hypothesis(one: NamedHypothesis) -> dict[str, object]:
    return {
        "effect": one.effect,
        "location": list(one.location),
        "probability": one.probability,
    }


def _cause(cause: Cause) -> dict[str, object]:
    simulated = cause.simulated
    return {
        "effect": cause.effect,
        "class": cause.group,
        "location": list(cause.location),
        "probability": cause.probability,
        "run": cause.run,
        "size": {
            name: {"value": size.value, "unit": size.unit, "ci95": list(size.ci95)}
            for name, size in cause.size.items()
        },
        "shrink": _pairs(vars(cause.shrink)),
        "simulated_shrink": None if simulated is None else _pairs(vars(simulated)),
        "hidden_cop_mm": cause.hidden_cop_mm,
    }


def _pairs(values: Mapping[str, object]) -> dict[str, object]:
    return {
        name: list(value) if isinstance(value, tuple) else value for name, value in values.items()
    }
