"""What the trials of chosen double supports say: figures, comparisons, and the page's section."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr, wilcoxon

from chosen_supports_results import Floor, Result
from pages import table
from population import nao

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """One column of the tables."""

    title: str
    unit: str
    decimals: int

    @property
    def head(self) -> str:
        """Title with unit."""
        return f"{self.title} [{self.unit}]"


MEASURES: Mapping[str, Measure] = {
    "gain": Measure("gains", "%", 2),
    "foot_grf": Measure("GRF of a foot", "N", 3),
    "foot_cop": Measure("CoP of a foot", "mm", 2),
    "worse_foot_cop": Measure("CoP of the worse foot", "mm", 2),
    "grf": Measure("GRF", "N", 3),
    "cop": Measure("CoP", "mm", 2),
}
PROMISES = {
    "gain": ("promised_gain", "stated_gain"),
    "foot_grf": ("promised_foot_grf", "stated_foot_grf"),
}
BASES = ("random", "spread")
"""Ways that the others are compared with."""
PAGE = """\
## Double supports: chosen against random

`make chosen-supports`: {robots} robots, each calibrated from three double supports (all fitted),
chosen in four ways: random as in the paper; `spread`, far apart and redrawn until all observable
directions are identified; `d_optimal` and `e_optimal`, with the least predicted uncertainty of all
directions together and of the worst one. Errors (MAE) are against contact forces on five further
runs: mean over robots, in brackets the worst robot. Gains: RMS of relative errors. A foot: the
mean of both.

{errors}

Compared with random, robot by robot (two-sided Wilcoxon signed-rank test): mean change of the
error, number of {robots} robots in which it fell, and p.

{against_random}

The same against `spread`:

{against_spread}

The default is `spread`: the others (`support_choice`) find better gains, but errors on other runs
are not smaller.

{reading}

Predicted before moving, predicted from the recording, and actual (medians over robots). The
prediction assumes model errors that are independent every two seconds, and correct cell positions.

{promises}

The prediction models the cells as a rigid body on equal springs, with `uneven_share` between the
feet. RMS against the true outputs over all runs:

{sharing}
"""


@dataclass(frozen=True)
class Figures:
    """One error over all robots."""

    mean: float
    median: float
    worst: float


@dataclass(frozen=True)
class Paired:
    """One error in one way against another way, robot by robot."""

    mean_difference: float
    better_in: int
    p_value: float

    @classmethod
    def of(cls, base: FloatArray, other: FloatArray) -> Paired:
        """Of errors (robots,) each."""
        test = wilcoxon(other, base)
        return cls(float(np.mean(other - base)), int(np.sum(other < base)), float(test.pvalue))


@dataclass(frozen=True)
class Promise:
    """One error as promised, as the recordings state it, and as it came out: medians by way.

    Attributes:
        rank_correlation: Spearman's, of promise and outcome over all trials.
    """

    promised: dict[str, float]
    stated: dict[str, float]
    outcome: dict[str, float]
    rank_correlation: float


@dataclass(frozen=True)
class Summary:
    """Everything that the trials say.

    Attributes:
        robots: number of them.
        ways: errors by way and measure.
        full_rank: in how many robots the recordings fixed every observable direction, by way.
        paired: by base, way and measure.
        promises: by measure.
        true_cop_mm, true_foot_cop_mm: mean errors under the true gains and offsets.
        sharing_n: by channel, see `Examination.sharing`.
    """

    robots: int
    ways: dict[str, dict[str, Figures]]
    full_rank: dict[str, int]
    paired: dict[str, dict[str, dict[str, Paired]]]
    promises: dict[str, Promise]
    true_cop_mm: float
    true_foot_cop_mm: float
    sharing_n: dict[str, tuple[float, float, float]]


def summarise(results: Sequence[Result], floor: Floor, ways: Sequence[str]) -> Summary:
    """Figures of all trials.

    Args:
        results: of every robot in every way.
        floor: of the robots.
        ways: their names.
    """

    def values(way: str, name: str) -> FloatArray:
        own = sorted((one for one in results if one.way == way), key=lambda one: one.seed)
        return np.array([getattr(one, name) for one in own])

    def medians(name: str) -> dict[str, float]:
        return {way: float(np.median(values(way, name))) for way in ways}

    def everywhere(name: str) -> FloatArray:
        return np.concatenate([values(way, name) for way in ways])

    possible = max(one.rank for one in results)
    return Summary(
        robots=len(floor.errors),
        ways={
            way: {
                name: Figures(
                    float(np.mean(values(way, name))),
                    float(np.median(values(way, name))),
                    float(np.max(values(way, name))),
                )
                for name in MEASURES
            }
            for way in ways
        },
        full_rank={way: int(np.sum(values(way, "rank") == possible)) for way in ways},
        paired={
            base: {
                way: {name: Paired.of(values(base, name), values(way, name)) for name in MEASURES}
                for way in ways
                if way != base
            }
            for base in BASES
        },
        promises={
            name: Promise(
                medians(promised),
                medians(stated),
                medians(name),
                float(spearmanr(everywhere(promised), everywhere(name)).statistic),
            )
            for name, (promised, stated) in PROMISES.items()
        },
        true_cop_mm=float(np.mean([1e3 * one.cop.mean for one in floor.errors])),
        true_foot_cop_mm=float(np.mean([1e3 * f.mean for e in floor.errors for f in e.foot_cop])),
        sharing_n=_sharing(floor.sharing),
    )


def _sharing(found: FloatArray) -> dict[str, tuple[float, float, float]]:
    each = np.sqrt(np.mean(found**2, axis=0)).T
    names = nao()[1].names
    return {
        name: (float(a), float(b), float(c)) for name, (a, b, c) in zip(names, each, strict=True)
    }


def page_body(summary: Summary) -> str:
    """The section of docs/evidence/trust.md."""
    return PAGE.format(
        robots=summary.robots,
        errors=_errors(summary),
        against_random=_paired(summary, "random"),
        against_spread=_paired(summary, "spread"),
        reading=_reading(summary),
        promises=_promises(summary),
        sharing=_sharing_table(summary),
    )


def _errors(summary: Summary) -> str:
    head = ["chosen", *(measure.head for measure in MEASURES.values()), "all directions fixed"]
    rows = [
        [
            _words(way),
            *(
                f"{figures[name].mean:.{measure.decimals}f} "
                f"({figures[name].worst:.{measure.decimals}f})"
                for name, measure in MEASURES.items()
            ),
            f"{summary.full_rank[way]} of {summary.robots}",
        ]
        for way, figures in summary.ways.items()
    ]
    return table([head, *rows])


def _paired(summary: Summary, base: str) -> str:
    head = ["chosen", *(measure.head for measure in MEASURES.values())]
    rows = [
        [
            _words(way),
            *(
                f"{found[name].mean_difference:+.{measure.decimals}f}, "
                f"{found[name].better_in}, p = {found[name].p_value:.2g}"
                for name, measure in MEASURES.items()
            ),
        ]
        for way, found in summary.paired[base].items()
        if way not in BASES[: BASES.index(base)]
    ]
    return table([head, *rows])


def _reading(summary: Summary) -> str:
    return (
        "How each foot's CoP comes out is bounded by the shoe, not by the double supports. With\n"
        f"each robot's true gains and offsets its error is {summary.true_foot_cop_mm:.2f} mm, that "
        f"of both feet together {summary.true_cop_mm:.2f} mm,\n"
        "as cells are not where the file says and plates carry some of the moment past them."
    )


def _promises(summary: Summary) -> str:
    rows = [["error", "chosen", "predicted by the plan", "predicted by the recording", "actual"]]
    for name, promise in summary.promises.items():
        measure = MEASURES[name]
        rows += [
            [
                measure.head,
                _words(way),
                *(
                    f"{figure[way]:.{measure.decimals}f}"
                    for figure in (promise.promised, promise.stated, promise.outcome)
                ),
            ]
            for way in promise.promised
        ]
    correlations = ", ".join(
        f"{MEASURES[name].title} {promise.rank_correlation:.2f}"
        for name, promise in summary.promises.items()
    )
    return (
        f"{table(rows)}\n\n"
        f"Rank correlation of prediction and outcome over all trials: {correlations}."
    )


def _sharing_table(summary: Summary) -> str:
    head = ["cell", "varies by [N]", "that is off by [N]", "mean is off by [N]"]
    rows = [
        [name, *(f"{figure:.2f}" for figure in figures)]
        for name, figures in summary.sharing_n.items()
    ]
    return table([head, *rows])


def _words(way: str) -> str:
    return "random, as the paper" if way == "random" else f"`{way}`"
