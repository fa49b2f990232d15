"""Every figure of the scoring table: its value, its interval, its target."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from blind.answers import CATEGORIES
from blind.cases import UNKNOWN, Case
from blind.catalogue import EFFECTS, alike
from blind.intervals import Interval, bootstrap, clopper_pearson
from shoecal_core.arrays import FloatArray

ONSET_S = 2.0
BINS = 10
"""Of the probabilities, when their calibration is looked at."""
FAR = 1e6
"""Stands for an infinite error, which JSON cannot hold."""


@dataclass(frozen=True)
class Figure:
    """One figure and its target.

    Attributes:
        says: what it is, for the table.
        value: None where no set tells it.
        interval: of 95 %.
        count: sets, or entries, that it is of.
        low, high: bounds that it should be within; None: none.
    """

    says: str
    value: float | None
    interval: Interval | None
    count: int
    low: float | None = None
    high: float | None = None

    @property
    def target(self) -> str:
        """The bounds in words; empty without."""
        if self.low is not None and self.high is not None:
            return f"{self.low:g} to {self.high:g}"
        if self.low is not None:
            return f">= {self.low:g}"
        return "" if self.high is None else f"<= {self.high:g}"

    @property
    def met(self) -> bool | None:
        """Whether the value is within; None without bounds or value."""
        if not self.target or self.value is None:
            return None
        return not (
            (self.low is not None and self.value < self.low)
            or (self.high is not None and self.value > self.high)
        )

    def to_json(self) -> dict[str, object]:
        """For out/blind.json."""
        return {
            "value": self.value,
            "interval": self.interval,
            "target": self.target or None,
            "met": self.met,
            "count": self.count,
        }


def rate(
    says: str, hits: Sequence[bool], *, low: float | None = None, high: float | None = None
) -> Figure:
    """A share with its exact interval."""
    if not hits:
        return Figure(says, None, None, 0, low, high)
    interval = clopper_pearson(sum(hits), len(hits))
    return Figure(says, sum(hits) / len(hits), interval, len(hits), low, high)


def statistic(
    says: str,
    rows: Sequence[Sequence[float]],
    figure: Callable[[FloatArray], float],
    *,
    low: float | None = None,
    high: float | None = None,
) -> Figure:
    """A figure of rows of values with its interval by drawing them again."""
    if not rows:
        return Figure(says, None, None, 0, low, high)
    finite = np.minimum(rows, FAR)
    return Figure(says, figure(finite), bootstrap(finite, figure), len(rows), low, high)


@dataclass(frozen=True)
class Targets:
    """What is aimed at, of one kind of worlds."""

    found: float
    false_alarms: float
    right_first: float
    right_among_three: float
    set_size: float
    exact_place: float
    unknown_called_unknown: float
    both_found: float


AS_BUILT = Targets(0.85, 0.05, 0.75, 0.90, 3.0, 0.75, 0.65, 0.55)
CLEAN = Targets(0.92, 0.02, 0.85, 0.95, 2.0, 0.90, 0.75, 0.65)


def figures(cases: Sequence[Case], aim: Targets = AS_BUILT) -> dict[str, Figure]:
    """All that one round of diagnoses tells, by key."""
    of: dict[str, list[Case]] = {
        name: [case for case in cases if case.answer.category == name] for name in CATEGORIES
    }
    gaps = [case for case in cases if case.answer.category != "clean" and case.certain]
    return {
        "found": rate(
            "found, where the gap is at least 1.5 x the floor",
            [case.found for case in gaps],
            low=aim.found,
        ),
        "false_alarms": rate(
            "healthy robots with a cause named",
            [bool(case.causes) for case in of["clean"]],
            high=aim.false_alarms,
        ),
        "clean_unknown": rate(
            "healthy robots called unknown", [case.verdict == UNKNOWN for case in of["clean"]]
        ),
        **_named([case for case in of["single"] if case.certain and case.found], aim),
        **_onset(of["single"]),
        **_unknown(of, aim),
        **_both([case for case in of["double"] if case.certain], aim),
        **_honest(cases),
        "errors": rate("diagnoses that failed", [case.said is None for case in cases]),
    }


def _named(cases: Sequence[Case], aim: Targets) -> dict[str, Figure]:
    """Of single effects that were found."""
    explained = [case for case in cases if case.verdict != UNKNOWN]
    placed = [case for case in cases if case.first_right and case.answer.truths[0].location]
    return {
        "right_first": rate(
            "right effect first", [case.first_right for case in cases], low=aim.right_first
        ),
        "right_among_three": rate(
            "right effect among three",
            [case.true_effects[0] in case.effects[:3] for case in cases],
            low=aim.right_among_three,
        ),
        "right_class": rate("right class first", [_right_class(case) for case in cases]),
        "truth_in_set": rate(
            "truth in the ambiguity set",
            [case.true_places[0] in case.places for case in explained],
            low=0.95,
        ),
        "set_size": statistic(
            "median size of the ambiguity set",
            [[len(case.places)] for case in explained],
            _median,
            high=aim.set_size,
        ),
        "exact_place": rate(
            "exact cell, joint or foot", [case.first_placed for case in placed], low=aim.exact_place
        ),
    }


def _right_class(case: Case) -> bool:
    return bool(case.causes) and any(
        case.causes[0]["class"] == EFFECTS[truth.effect].group for truth in case.answer.truths
    )


def _onset(cases: Sequence[Case]) -> dict[str, Figure]:
    errors = [error for case in cases if case.certain and (error := case.onset_error()) is not None]
    return {
        "onset_error_s": statistic(
            "onset of slip or step, median error (s)",
            [[one] for one in errors],
            _median,
            high=ONSET_S,
        ),
        "onset_within_2_s": rate(
            "onset of slip or step within 2 s", [error <= ONSET_S for error in errors]
        ),
    }


def _unknown(of: Mapping[str, Sequence[Case]], aim: Targets) -> dict[str, Figure]:
    known = [case for case in (*of["single"], *of["double"]) if case.certain]
    return {
        "unknown_called_unknown": rate(
            "unknown effects called unknown",
            [case.verdict == UNKNOWN for case in of["unknown"] if case.certain],
            low=aim.unknown_called_unknown,
        ),
        "known_called_unknown": rate(
            "known ones called unknown",
            [case.verdict == UNKNOWN for case in known],
            high=0.10,
        ),
    }


def _both(cases: Sequence[Case], aim: Targets) -> dict[str, Figure]:
    """Of two effects at once."""
    named = [[alike(str(cause["effect"])) for cause in case.causes] for case in cases]
    right = [
        effect in case.true_effects
        for case, effects in zip(cases, named, strict=True)
        for effect in effects
    ]
    return {
        "both_found": rate(
            "both of two found",
            [{*case.true_effects} <= {*names} for case, names in zip(cases, named, strict=True)],
            low=aim.both_found,
        ),
        "double_precision": rate("precision, of two", right, low=0.85),
    }


def _honest(cases: Sequence[Case]) -> dict[str, Figure]:
    """Do stated uncertainties hold?"""
    told = [case for case in cases if case.causes]
    held = [one for case in cases for one in case.held()]
    rows = [[float(case.causes[0]["probability"]), float(case.first_placed)] for case in told]
    return {
        "intervals_hold": rate("95 % intervals that hold", held, low=0.90, high=0.98),
        "calibration_error": statistic(
            "calibration error of the probabilities", rows, calibration_error, high=0.07
        ),
    }


def shrink_figures(pairs: Sequence[tuple[Case, Case]]) -> dict[str, Figure]:
    """Shrink with what was found over shrink with the true effect.

    Args:
        pairs: of single sets, as diagnosed and with the true effect prescribed.
    """
    ratios = [
        [shrink_of(found) / shrink_of(true)]
        for found, true in pairs
        if found.certain and found.found and shrink_of(true) > 0.0
    ]
    return {
        "shrink_median": statistic(
            "shrink against that of the true effect, median", ratios, _median, low=0.90
        ),
        "shrink_10th_percentile": statistic("the same, 10th percentile", ratios, _tenth, low=0.60),
    }


def shrink_of(case: Case) -> float:
    """Share of the gap that the explanation takes away on test runs; 0 without one."""
    return max((float(cause["shrink"]["fraction"]) for cause in case.causes), default=0.0)


def calibration_error(rows: FloatArray) -> float:
    """Mean distance of stated probabilities and true shares, bin by bin.

    Args:
        rows: (n, 2) probability, and whether it was right.
    """
    bins = np.minimum((rows[:, 0] * BINS).astype(int), BINS - 1)
    far = [
        np.sum(bins == one) * abs(float(np.diff(rows[bins == one].mean(axis=0))[0]))
        for one in np.unique(bins)
    ]
    return float(np.sum(far) / len(rows))


def _median(values: FloatArray) -> float:
    return float(np.median(values))


def _tenth(values: FloatArray) -> float:
    return float(np.quantile(values, 0.1))
