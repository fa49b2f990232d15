"""The section `faults` of docs/evidence/trust.md: how many faults are caught, and false alarms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import beta

from pages import TRUST, record, table, write_section
from shoecal_core.calibration.screening.faults import Fault

Results = Sequence[Mapping[str, Any]]

WANTED_CAUGHT, ALLOWED_ALARMS = 0.95, 0.02
LEVEL = 0.95
DRAWN: Mapping[str, str] = {
    "dead cell": "one cell gives 0, another constant, or noise alone",
    "stuck cell": "from some moment of one run on, one cell stays at its last value, or trembles "
    "about it",
    "saturated cell": "one cell goes no further than a level inside its range, for 3 to 30 % of "
    "the session; typically 0.4 N or more are cut off",
    "inverted cell": "one cell's sign is turned",
    "swapped cells": "two cells, of one foot or of both, are read as each other",
    "outliers": "3 to 60 spikes of one to three samples, 1 to 60 N, in one cell and run",
    "time offset": "all readings are stamped 20 to 150 ms late or early; found within 10 ms",
    "wrong weight": "in one run the robot carries 1.8 to 10 N on its torso or in a hand, or is "
    "held by that much",
    "jolt": "the torso is pushed with 1.5 to 15 N for 0.05 to 0.4 s",
    "hasty motion": "3 to 8 s of the plan are done 3 to 7 times as fast; samples whose true CoP "
    "leaves the slow motion's by more than 5 mm",
    "lifted foot": "one leg is drawn up for 0.6 to 2 s; samples at which its foot carries nothing",
    "slipped foot": "a foot loses its grip, is pulled, and comes to rest 3 to 10 mm away",
}
"""What is put in, by fault."""


def write_page(results: Mapping[str, Results], clean: str) -> None:
    """Write the section and the figures.

    Args:
        results: of every fault's draws, and of clean ones.
        clean: name of these.
    """
    faults = {name: found for name, found in results.items() if name != clean}
    figures = {name: _figures(found) for name, found in faults.items()}
    alarms = _rate(results[clean])
    lost = {
        fault.value: float(
            np.mean([one["left_out"].get(fault.value, 0.0) for one in results[clean]])
        )
        for fault in Fault
    }
    body = PAGE.format(
        table=table(
            [
                ("fault", "drawn", "caught", "95 % interval", "refused", "left out", "CoP (mm)"),
                *(_row(name, figures[name]) for name in faults),
            ]
        ),
        draws=len(next(iter(faults.values()))),
        alarms=f"{alarms['count']} of {alarms['draws']}",
        rate=_percent(alarms["rate"]),
        interval=_interval(alarms),
        coarse=sum(one["bits"] is not None for one in results[clean]),
        lost=", ".join(
            f"{share:.2%} {name.replace('_', ' ')}" for name, share in lost.items() if share > 0.0
        ),
        cases=_cases(results[clean]),
        met=_met(figures, alarms),
    )
    figures_of_all = {
        "faults": figures,
        "clean": {**alarms, "left_out": lost},
        "met": _missed(figures, alarms) == [],
    }
    record("caught_faults", figures_of_all)
    write_section("faults", body, TRUST)


def clopper_pearson(count: int, draws: int) -> tuple[float, float]:
    """Exact 95 % interval of a rate (Clopper and Pearson, 1934)."""
    tail = (1.0 - LEVEL) / 2.0
    low = 0.0 if count == 0 else float(beta.ppf(tail, count, draws - count + 1))
    high = 1.0 if count == draws else float(beta.ppf(1.0 - tail, count + 1, draws - count))
    return low, high


def _rate(found: Results) -> dict[str, Any]:
    count = sum(bool(one["caught"]) for one in found)
    low, high = clopper_pearson(count, len(found))
    return {
        "draws": len(found), "count": count, "rate": count / len(found), "low": low, "high": high
    }  # fmt: skip


def _figures(found: Results) -> dict[str, Any]:
    solved = [one for one in found if not one["refused"]]
    worse = [one["cop_mm"] - one["clean_cop_mm"] for one in solved]
    return {
        **_rate(found),
        "named": sum(bool(one["named"]) for one in found),
        "refused": len(found) - len(solved),
        "left_out": sum(one["covered"] for one in solved) / max(len(solved), 1),
        "cop_mm": float(np.median([one["cop_mm"] for one in solved])) if solved else None,
        "clean_cop_mm": (
            float(np.median([one["clean_cop_mm"] for one in solved])) if solved else None
        ),
        "worse_mm": float(np.median(worse)) if worse else None,
        "passed": sum(one["verdict"] == "PASS" for one in found),
    }


def _row(name: str, found: Mapping[str, Any]) -> tuple[str, ...]:
    cop = "-"
    if found["cop_mm"] is not None:
        cop = f"{found['cop_mm']:.1f} ({found['clean_cop_mm']:.1f})"
    return (
        name,
        DRAWN[name],
        f"{found['count']} of {found['draws']}",
        _interval(found),
        str(found["refused"]),
        "-" if found["cop_mm"] is None else _percent(found["left_out"]),
        cop,
    )


def _interval(rate: Mapping[str, Any]) -> str:
    return f"{_percent(rate['low'])} to {_percent(rate['high'])}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _missed(figures: Mapping[str, Mapping[str, Any]], alarms: Mapping[str, Any]) -> list[str]:
    missed = [name for name, one in figures.items() if one["rate"] < WANTED_CAUGHT]
    return missed + (["false alarms"] if alarms["rate"] > ALLOWED_ALARMS else [])


def _met(figures: Mapping[str, Mapping[str, Any]], alarms: Mapping[str, Any]) -> str:
    missed = _missed(figures, alarms)
    if not missed:
        return "Every kind meets the aim of 95 %, and the alarms stay within 2 %."
    return f"The aim (95 % of each kind, alarms within 2 %) is missed by: {', '.join(missed)}."


def _cases(found: Results) -> str:
    told = [f"seed {one['seed']}: {one['told'].split('; ')[0]}" for one in found if one["told"]]
    return "".join(f"\n- {line}" for line in told)


PAGE = """\
## Faults of a recording

    make caught-faults

{draws} draws of each fault, each with another robot, cells and five double supports
(`benchmarks/population.py`). Faults of the robot (weight, jolts, haste, lifted or slipped foot) are
simulated, the others put into the readings. In a third of the draws the converter has 10 to 12 bits
and up to 0.15 N of noise instead of 24 bits and 0.01 N.

A fault is *caught* if it is named (with cell, run or time) and the session is refused, or at least
95 % of its samples are excluded. *Refused*: sessions without a calibration. *Left out*: excluded
share of the spoilt samples in the others. *CoP*: mean error of each foot's CoP on untouched runs,
median of the draws; in brackets without the fault.

{table}

False alarms: {alarms} clean sessions ({rate}, 95 % interval {interval}; {coarse} of them with the
poorer converter) have any warning or refusal of the screening.{cases}

In the clean sessions {lost} of the samples are excluded, because of backlash impacts. {met}

Thresholds were set on the odd seeds of the population; these are the even ones. Intervals are
exact (Clopper and Pearson). [Not detectable](../reference/screening.md#not-detectable).
"""
