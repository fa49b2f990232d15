"""What `diagnose` says of the REEM-C's trials, each held out once."""

from __future__ import annotations

from pages import Row
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import Cause, Diagnosis
from shoecal_core.recording.session import Session

ZEROS, WEIGHT = "zero_offset", "total_mass"


def tables(session: Session) -> dict[str, list[Row]]:
    """By the sections of docs/evidence/real-robots.md; a row a trial that is held out."""
    names = {entry.run: f"{entry.run} {entry.info.motion}" for entry in session.runs}
    rows: list[Row] = []
    for run, name in names.items():
        train = [other for other in names if other != run]
        rows.append({"held out": name, **_row(diagnose(session, train, (run,)))})
    return {"diagnosis": rows}


def _row(found: Diagnosis) -> Row:
    """Causes in the order in which they are named, and errors before and with all of them."""
    zeros = [one for one in found.causes if one.effect == ZEROS]
    weights = [one for one in found.causes if one.effect == WEIGHT]
    others = [one.label for one in found.causes if one.effect not in {ZEROS, WEIGHT}]
    offsets = [one.size["offset"].value for one in zeros]
    runs = sorted({one.run for one in zeros if one.run is not None})
    shrink = found.shrink
    none = (found.gap.cop_mae_mm,) * 2, (found.gap.grf_mae_n,) * 2
    cop, grf = none if shrink is None else (shrink.cop_mae_mm, shrink.grf_mae_n)
    return {
        "verdict": found.verdict,
        "first": found.causes[0].effect if found.causes else "none",
        "zeros moved in trials": ", ".join(map(str, runs)),
        "by (N)": f"{min(offsets):.0f} to {max(offsets):.0f}" if offsets else "",
        "weight (95 %) [kg]": _heavier(weights),
        "else": ", ".join(others) or "nothing",
        "GRF (N)": f"{grf[0]:.1f} → {grf[1]:.1f}",
        "CoP (mm)": f"{cop[0]:.1f} → {cop[1]:.1f}",
    }


def _heavier(weights: list[Cause]) -> str:
    if not weights:
        return ""
    size = weights[0].size["mass"]
    low, high = size.ci95
    return f"{size.value:+.1f} ({low:.1f} to {high:.1f})"
