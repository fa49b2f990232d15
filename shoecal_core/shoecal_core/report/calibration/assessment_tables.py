"""Expected errors of a calibration and what would make them smaller, as tables."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import UNKNOWN, number, size
from shoecal_core.shoe.shoe import FEET

NAMES = {
    "backlash": "play of the gears",
    "cell_position": "places of the cells",
    "gains_and_offsets": "gains and offsets left to the prior",
    "joint_compliance": "compliance of the gears",
    "joint_offset": "zeros of the joints",
    "link_com": "centres of mass of the links",
    "link_mass": "masses of the links",
    "noise": "noise and model form error",
    "placement": "feet that stand elsewhere in a run",
    "plates": "plates that carry load past the cells",
    "sideways_force": "sideways forces at the cells' height",
    "soft_ground": "soles that tilt under load",
    "support": "where the right foot stands",
    "time_offset": "time offset of the joints",
    "zero_offset": "zeros of single runs",
}
CURES = {
    "cell_position": "measure where the cells are, or calibrate the shoe manually",
    "plates": "calibrate the shoe manually, with known weights",
    "joint_offset": "calibrate the robot's joints",
    "link_com": "measure the links' balance points",
    "link_mass": "weigh the links",
    "joint_compliance": "measure how far the joints give under load",
    "backlash": "measure the play of the joints",
    "zero_offset": "lift each foot in every run",
    "soft_ground": "stand on a stiff floor",
}
LISTED_SOURCES, LEAST_WIN = 6, 0.005


def source_name(effect: str) -> str:
    """Its name for a person."""
    return NAMES.get(effect, effect.replace("_", " "))


def cure(effect: str) -> str | None:
    """What would make it smaller; None where nothing is known to."""
    return CURES.get(effect)


def carried(assessed: Assessment) -> bool:
    """The model's own errors are part of the uncertainties; of walking they are not."""
    return assessed.budget is not None


def rms(values: FloatArray) -> float:
    """Root mean square of values (p,) in their unit; NaN is left out."""
    return float(np.sqrt(np.nanmean(values**2)))


def expected_table(assessed: Assessment) -> Table:
    """Expected errors of GRF and CoP."""
    rows = []
    for label, spread in zip(
        ("both feet", *(f"{side} foot" for side in FEET)),
        (assessed.both, *assessed.feet),
        strict=True,
    ):
        lengths = spread.cop_mean[np.isfinite(spread.cop_mean)]
        rows.append(
            (
                label,
                size(rms(spread.grf), "N"),
                size(1e3 * float(lengths.mean()), "mm") if len(lengths) else UNKNOWN,
                *(size(1e3 * rms(spread.cop[:, axis]), "mm") for axis in (0, 1)),
                size(1e3 * float(lengths.max()), "mm") if len(lengths) else UNKNOWN,
            )
        )
    return Table(
        "Expected errors" if carried(assessed) else "Known part of the errors",
        ("", "GRF", "CoP", "CoP along x", "CoP along y", "CoP, worst place"),
        tuple(rows),
        "CoP: mean absolute error over the sensing polygons. GRF, and the CoP along one axis: "
        "one standard deviation. Both feet: in the neutral double support, CoP anywhere between "
        "them. One foot: under half the weight.",
    )


def helps_table(assessed: Assessment) -> Table | None:
    """What knowing an error source exactly would win; None where that is not known."""
    budget = assessed.budget
    if budget is None:
        return None
    known = [
        one
        for one in budget.sources
        if cure(one.effect) is not None
        and np.isfinite(one.without).all()
        and (one.without < (1.0 - LEAST_WIN) * budget.total).any()
    ]
    if not known:
        return None
    known.sort(key=lambda one: float(np.sum(one.without**2)))
    # The budget is of mean squares; errors are stated as means of their size.
    mean = np.array([one.cop_mae for one in (assessed.both, *assessed.feet)])
    rows = tuple(
        (
            source_name(one.effect),
            *(
                _falls(float(now), float(now * ratio))
                for now, ratio in zip(mean, one.without / budget.total, strict=True)
            ),
            cure(one.effect) or UNKNOWN,
        )
        for one in known
    )
    rows = tuple(row for row in rows if set(row[1:-1]) != {UNKNOWN})[:LISTED_SOURCES]
    if not rows:
        return None
    return Table(
        "What would help most",
        ("if known exactly", "both feet", *(f"{side} foot" for side in FEET), "how"),
        rows,
        "Expected CoP error before → after, as in the table of expected errors."
        + f" {another_text(assessed)}".rstrip(),
    )


def another_text(assessed: Assessment) -> str:
    """What recording a run once more would win; empty where that is not known."""
    if assessed.another is None:
        return ""
    both, feet = assessed.expected_cop()
    then, feet_then = assessed.expected_cop_with_another()
    falls = [("both feet", both, then)]
    falls += [(f"{name} foot", size, feet_then[name]) for name, size in feet.items()]
    won = [f"{name} {fall}" for name, *sizes in falls if (fall := _falls(*sizes)) != UNKNOWN]
    run = f"Run {assessed.another.run} recorded once more"
    return f"{run}, expected CoP error: {', '.join(won)}." if won else f"{run} would win nothing."


def _falls(now: float, then: float) -> str:
    """Both in mm; a dash where nothing changes."""
    decimals = 1 if now < 0.01 else 0
    before, after = (number(1e3 * value, decimals) for value in (now, then))
    return UNKNOWN if before == after else f"{before} → {after} mm"
