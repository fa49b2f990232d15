"""Tables of docs/evidence/trust.md that `accuracy.py` writes, by motions and reality.

Errors are medians over robots, in brackets of the worst one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from accuracy_results import Result
from accuracy_sessions import PAPER
from held import COPS, WHAT, Held
from pages import Row
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95
from shoecal_core.shoe.shoe import FEET

ERRORS = {
    "CoP, both feet [mm]": "cop",
    **{f"{foot} [mm]": f"{foot}_cop" for foot in FEET},
    **{f"GRF, {foot} [N]": f"{foot}_grf" for foot in FEET},
    "GRF, sum* [N]": "grf",
}
"""Columns, and their figures of `Errors.figures`."""
Groups = dict[tuple[str, str], list[Result]]


def tables(results: Sequence[Result]) -> dict[str, list[Row]]:
    """By the sections of the page."""
    groups = grouped(results)
    return {
        "accuracy": errors(groups),
        "intervals": intervals(groups),
        "gains": gains(groups),
        "budget": budget(groups),
    }


def grouped(results: Sequence[Result]) -> Groups:
    """By motions and reality, with the prior; the paper's protocol first.

    Those of which no session could be calibrated are left out.
    """
    found: Groups = {}
    for one in sorted(results, key=lambda one: one.case.motions != PAPER):
        reality = one.case.reality + (", `--manual`" if one.case.manual else "")
        found.setdefault((one.case.motions, reality), []).append(one)
    return {where: those for where, those in found.items() if _calibrated(those)}


def _calibrated(results: Sequence[Result]) -> list[Result]:
    """Those of which a calibration came, whatever its verdict."""
    return [one for one in results if one.errors is not None]


def _held(results: Sequence[Result]) -> list[Held]:
    """Stated uncertainties of those that have test runs."""
    return [one.held for one in results if one.held is not None]


def errors(groups: Groups) -> list[Row]:
    """MAE on the test runs, verdicts and processor time."""
    rows: list[Row] = []
    for (motions, reality), results in groups.items():
        found = [one.errors.figures() for one in results if one.errors is not None]
        maes = {
            column: [scale * mae.mean for mae, scale, _ in (one[name] for one in found)]
            for column, name in ERRORS.items()
        }
        seeds = [one.case.seed for one in results]
        verdicts = Counter(one.verdict for one in results)
        rows.append(
            {
                "motions": motions,
                "reality": reality,
                "seeds": f"{min(seeds)} to {max(seeds)}",
                **{name: f"{np.median(of):.2f} ({max(of):.2f})" for name, of in maes.items()},
                "verdicts": ", ".join(f"{count} {name}" for name, count in verdicts.items()),
                "time [s]": f"{np.median([one.seconds for one in _calibrated(results)]):.1f}",
            }
        )
    return rows


def intervals(groups: Groups) -> list[Row]:
    """Share of true errors inside stated 95 % intervals, ± half its own 95 % interval; RMS of
    errors over their standard deviations.
    """
    rows: list[Row] = []
    for (motions, reality), results in groups.items():
        held = _held(results)
        expected, actual = (
            1e3 * np.median([getattr(one, name) for one in held], axis=0)
            for name in ("expected", "actual")
        )
        rows.append(
            {
                "motions": motions,
                "reality": reality,
                **{name: "{:.0%} (± {:.0%})".format(*inside(held, name)) for name in WHAT},
                "CoP, RMS of error / standard deviation: both, left, right": ", ".join(
                    f"{root_mean_square(held, name):.2f}" for name in COPS
                ),
                "CoP expected / true: both, left, right [mm, RMS]": ", ".join(
                    f"{a:.1f} / {b:.1f}" for a, b in zip(expected, actual, strict=True)
                ),
            }
        )
    return rows


def inside(held: Sequence[Held], quantity: str) -> tuple[float, float]:
    """Share of errors inside their 95 % intervals, and half its own 95 % interval.

    The unit is the calibration: its samples err together.
    """
    ratios = [one.ratios[quantity] for one in held]
    shares = np.array([np.mean(np.abs(one) < NORMAL_95) for one in ratios if one.size])
    spread = float(shares.std(ddof=1)) if len(shares) > 1 else float("nan")
    return float(shares.mean()), NORMAL_95 * spread / float(np.sqrt(len(shares)))


def root_mean_square(held: Sequence[Held], quantity: str) -> float:
    """Of errors over their standard deviations, every calibration alike: 1 as it should be."""
    return float(np.sqrt(np.mean([np.mean(one.ratios[quantity] ** 2) for one in held])))


def gains(groups: Groups) -> list[Row]:
    """Found over true gain, minus 1; cells of one robot err together."""
    rows: list[Row] = []
    for (motions, reality), results in groups.items():
        found = 100.0 * np.array([one.gain_errors for one in _calibrated(results)])
        half = NORMAL_95 * found.mean(axis=1).std() / np.sqrt(len(found))
        rows.append(
            {
                "motions": motions,
                "reality": reality,
                "bias [%]": f"{found.mean():+.2f} ± {half:.2f}",
                "spread [%]": f"{found.std():.2f}",
            }
        )
    return rows


def budget(groups: Groups) -> list[Row]:
    """Share of robots whose budget holds a source's true share: both feet, left, right."""
    names = dict.fromkeys(
        name for results in groups.values() for one in results for name in one.budget
    )
    return [
        {
            "source": name.replace("_", " "),
            **{", ".join(where): _share(results, name) for where, results in groups.items()},
        }
        for name in names
    ]


def _share(results: Sequence[Result], source: str) -> str:
    held = [one.budget[source] for one in results if source in one.budget]
    return ", ".join(f"{share:.0%}" for share in np.mean(held, axis=0)) if held else "-"
