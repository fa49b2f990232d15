"""Tables of docs/evidence/trust.md: how many faults of a recording are caught, and false alarms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from blind.intervals import clopper_pearson
from pages import Row

Results = Sequence[Mapping[str, Any]]
"""Of one fault's draws, as `caught_faults.py` keeps them."""


def caught(faults: Mapping[str, Results]) -> list[Row]:
    """One row a fault."""
    rows: list[Row] = []
    for name, found in faults.items():
        solved = [one for one in found if not one["refused"]]
        rows.append(
            {
                "fault": name,
                **_rate("caught", found),
                "refused": len(found) - len(solved),
                "left out": percent(np.mean([one["covered"] for one in solved])) if solved else "-",
                "CoP (mm)": f"{_median(solved, 'cop_mm')} ({_median(solved, 'clean_cop_mm')})"
                if solved
                else "-",
            }
        )
    return rows


def alarms(clean: Results) -> list[Row]:
    """Of sessions without a fault: warnings or refusals, and the samples left out all the same."""
    return [
        {
            "clean sessions": len(clean),
            "with the poorer converter": sum(one["bits"] is not None for one in clean),
            **_rate("false alarms", clean),
            "samples left out": percent(np.mean([one["left_out"] for one in clean])),
        }
    ]


def _rate(name: str, found: Results) -> Row:
    count = sum(bool(one["caught"]) for one in found)
    low, high = clopper_pearson(count, len(found))
    return {
        name: f"{count} of {len(found)}",
        "95 % interval": f"{percent(low)} to {percent(high)}",
    }


def _median(found: Results, figure: str) -> str:
    return f"{np.median([one[figure] for one in found]):.1f}"


def percent(share: float | np.floating[Any]) -> str:
    """A share as tables have it."""
    return f"{100.0 * share:.1f} %"
