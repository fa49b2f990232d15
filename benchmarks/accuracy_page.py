"""The section of docs/evidence/trust.md and the figures that `accuracy.py` writes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from accuracy_results import REFUSED, Result
from accuracy_sessions import MOTIONS, PAPER, STANDARD
from held import COPS, WHAT, Held
from pages import table
from shoecal_core.calibration.assessment import NORMAL_95
from shoecal_core.sensing.shoe import FEET

FloatArray = NDArray[np.float64]
ERRORS = {
    "CoP, both feet [mm]": "cop",
    **{f"{foot} [mm]": f"{foot}_cop" for foot in FEET},
    **{f"GRF, {foot} [N]": f"{foot}_grf" for foot in FEET},
    "GRF, sum* [N]": "grf",
}
"""Columns, and their figures of `Errors.figures`."""
LOWEST, HIGHEST = 0.90, 0.98
"""Of a share that should be 95 %."""


@dataclass(frozen=True)
class Group:
    """All sessions of one kind of motions in one reality, with one prior."""

    motions: str
    reality: str
    manual: bool
    results: Sequence[Result]

    @property
    def where(self) -> str:
        """Its reality, and the prior that it had."""
        return self.reality + (", `--manual`" if self.manual else "")

    @property
    def calibrated(self) -> list[Result]:
        """Those of which a calibration came, whatever its verdict."""
        return [one for one in self.results if one.errors is not None]

    def errors(self, name: str) -> FloatArray:
        """(k,) MAEs by session [mm or N]."""
        found = []
        for one in self.calibrated:
            assert one.errors is not None
            mae, scale, _ = one.errors.figures()[name]
            found.append(scale * mae.mean)
        return np.array(found)

    def gain_errors(self) -> FloatArray:
        """(k, n) relative errors of gains."""
        return np.array([one.gain_errors for one in self.calibrated])

    def held(self) -> list[Held]:
        """Stated uncertainties of those that have test runs."""
        return [one.held for one in self.calibrated if one.held is not None]

    @property
    def sources(self) -> list[str]:
        """Of the CoP error, those with a budget."""
        return list(dict.fromkeys(name for one in self.calibrated for name in one.budget))

    def budget(self, source: str) -> FloatArray:
        """(3,) share of robots whose budget holds a source's true share: both feet, left, right."""
        held = [one.budget[source] for one in self.calibrated if source in one.budget]
        return np.mean(held, axis=0) if held else np.full(3, np.nan)

    def inside(self, quantity: str) -> tuple[float, float]:
        """Share of errors inside their 95 % intervals, and half its own 95 % interval."""
        ratios = [one.ratios[quantity] for one in self.held()]
        # The unit is the calibration: its samples err together.
        shares = np.array([np.mean(np.abs(one) < NORMAL_95) for one in ratios if one.size])
        spread = float(shares.std(ddof=1)) if len(shares) > 1 else float("nan")
        return float(shares.mean()), NORMAL_95 * spread / float(np.sqrt(len(shares)))

    def to_json(self) -> dict[str, object]:
        """Figures for machines; errors are medians over sessions."""
        gains = self.gain_errors()
        return {
            "sessions": len(self.results),
            "calibrated": len(self.calibrated),
            "verdicts": _counted([one.verdict for one in self.results]),
            "median": {name: float(np.median(self.errors(name))) for name in ERRORS.values()},
            "inside": {name: self.inside(name)[0] for name in WHAT},
            "budget_inside": {name: self.budget(name).tolist() for name in self.sources},
            "gain_bias": float(gains.mean()),
            "gain_spread": float(gains.std()),
            "seconds": float(np.median([one.seconds for one in self.calibrated])),
        }


def groups(results: Sequence[Result]) -> list[Group]:
    """By motions and reality, in their order; those without a calibration are left out."""
    kinds: dict[tuple[str, str, bool], list[Result]] = {}
    for one in results:
        kinds.setdefault((one.case.motions, one.case.reality, one.case.manual), []).append(one)
    found = [Group(*kind, those) for kind, those in kinds.items()]
    return sorted((one for one in found if one.calibrated), key=lambda one: one.motions != PAPER)


def figures(results: Sequence[Result]) -> dict[str, object]:
    """For machines, by motions and reality."""
    return {f"{one.motions}, {one.where}": one.to_json() for one in groups(results)}


def section(results: Sequence[Result], unrecorded: int) -> str:
    """The part of the page."""
    seeds = sorted({one.case.seed for one in results})
    found = groups(results)
    refused = [
        f"{one.case.motions} {one.case.reality} seed {one.case.seed}: {one.reason.split('; ')[0]}"
        for one in results
        if one.verdict == REFUSED
    ]
    return f"""\
## Accuracy, and whether it is what is stated
`make accuracy` (benchmarks/accuracy.py), simulated: {len(seeds)} robots, seeds {seeds[0]} to
{seeds[-1]}, the same in every reality (`config/realities`,
[simulation](../reference/simulation.md#realities)). Each is calibrated as `shoecal calibrate`
does without options, from the {MOTIONS[PAPER]} (`{PAPER}`) and from the {MOTIONS[STANDARD]}
(`{STANDARD}`); with `--manual` a simulated manual calibration of the same shoes is the prior.

Errors against contact forces on the test runs (MAE, as `shoecal evaluate` reports them): the median
of the robots, and in brackets the worst one.

{table(list(_error_rows(found)))}

\\* The error of the sum is that of the weight: what the scale was off by. What tests a calibration
is the GRF of each foot. Noise of single readings is no error of a calibration: where they are
noisy, errors are those on the same motions read without (0.01 N). A verdict FAIL writes no
calibration; its errors count here all the same. Time: of the processor, median.

Sessions that could not be recorded: {unrecorded}. Refused: {"; ".join(refused) or "none"}.

### Whether stated intervals hold
The share of true errors inside stated 95 % intervals, which should be 95 %, and in brackets how
well it is known from these robots. CoP and GRF: of the test runs, without CoP corrections. Single
offsets are not in the table: four cells of a foot leave one pattern of them open that changes
neither force nor CoP.

{table(list(_inside_rows(found)))}

The aim is {LOWEST:.0%} to {HIGHEST:.0%} for each CoP; {_outside(found)}. GRF holds more often: the
simulated scale is off by 0.19 N always, the robot file states 0.29 N. So does the time offset,
which is zero in every simulated robot.

### Gains
Found over true gain, over all cells and robots: the mean is a bias.

{table(list(_gain_rows(found)))}

### Budget of the CoP error
A calibration says which source has which share of the expected CoP error, with a 95 % interval. The
share of robots whose true share lies inside: of both feet, left, right; the aim is 90 %. Where the
right foot stands is not recorded as truth, and what the fit says of it counts as true; sideways
forces are not estimated. Both have no row.

{table(list(_budget_rows(found)))}
"""


def _error_rows(found: Sequence[Group]) -> Iterator[list[str]]:
    yield ["motions", "reality", *ERRORS, "verdicts", "time [s]"]
    for group in found:
        cells = []
        for name in ERRORS.values():
            values = group.errors(name)
            cells.append(f"{np.median(values):.2f} ({values.max():.2f})")
        verdicts = _counted([one.verdict for one in group.results])
        told = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
        seconds = np.median([one.seconds for one in group.calibrated])
        yield [group.motions, group.where, *cells, told, f"{seconds:.1f}"]


def _inside_rows(found: Sequence[Group]) -> Iterator[list[str]]:
    yield ["motions", "reality", *WHAT, "CoP expected / true: both, left, right [mm, RMS]"]
    for group in found:
        cells = []
        for name in WHAT:
            share, half = group.inside(name)
            cells.append(f"{share:.0%} (± {half:.0%})")
        expected, actual = (
            1e3 * np.median([getattr(one, name) for one in group.held()], axis=0)
            for name in ("expected", "actual")
        )
        both = ", ".join(f"{a:.1f} / {b:.1f}" for a, b in zip(expected, actual, strict=True))
        yield [group.motions, group.where, *cells, both]


def _gain_rows(found: Sequence[Group]) -> Iterator[list[str]]:
    yield ["motions", "reality", "bias [%]", "spread [%]"]
    for group in found:
        gains = 100.0 * group.gain_errors()
        # Cells of one robot err together.
        half = NORMAL_95 * gains.mean(axis=1).std() / np.sqrt(len(gains))
        yield [
            group.motions,
            group.where,
            f"{gains.mean():+.2f} ± {half:.2f}",
            f"{gains.std():.2f}",
        ]


def _budget_rows(found: Sequence[Group]) -> Iterator[list[str]]:
    yield ["source", *(f"{group.motions}, {group.where}" for group in found)]
    for name in dict.fromkeys(name for group in found for name in group.sources):
        shares = [group.budget(name) for group in found]
        yield [
            name.replace("_", " "),
            *("-" if np.isnan(one).any() else ", ".join(f"{x:.0%}" for x in one) for one in shares),
        ]


def _outside(found: Sequence[Group]) -> str:
    shares = [group.inside(name)[0] for group in found for name in COPS]
    inside = sum(LOWEST <= share <= HIGHEST for share in shares)
    return f"it is met in {inside} of {len(shares)} cells of the table"


def _counted(words: Sequence[str]) -> dict[str, int]:
    return {word: words.count(word) for word in sorted(set(words))}
