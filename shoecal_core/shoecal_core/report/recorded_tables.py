"""What a recording shows before the fit, for a page and a terminal: zeros, what does not count."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.report.page import Group, Section, Table
from shoecal_core.report.quantities import UNKNOWN, quantity, uncertain
from shoecal_core.samples.zeros import ZeroFigures
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening


def zeros_table(zeros: Sequence[ZeroFigures]) -> Table:
    """What feet read in the air: one line a run and foot."""
    rows = tuple(
        (
            f"run {one['run']}",
            one["foot"],
            uncertain(one["fz_n"], 0.5 * (one["ci95"][1] - one["ci95"][0]), "N"),
            quantity(one["left_n"], "N", 1) if "left_n" in one else UNKNOWN,
        )
        for one in zeros
    )
    header = ("", "foot", "vertical force in the air (95 %)", "left by the calibration")
    return Table("Zeros, run by run", header, rows)


def zeros_section(zeros: Sequence[ZeroFigures]) -> tuple[Section, ...]:
    """The same as a section; none without any."""
    if not zeros:
        return ()
    text = (
        "A foot in the air carries nothing: what it reads is its zero. By the gains of the data "
        "sheets without offsets; where there are none, by the calibration. Zeros that change from "
        "run to run ask for each run's own (--rezero)."
    )
    return (Section("Feet in the air", (Group(tables=(zeros_table(zeros),)),), text),)


def cause_name(fault: Fault) -> str:
    """A fault's name for a person."""
    return fault.value.replace("_", " ")


def left_out_table(screening: Screening) -> Table | None:
    """Samples that do not count, by run and cause; None without any."""
    if not screening.left_out:
        return None
    lost = {(one.run, one.fault): one for one in screening.left_out}
    faults = [fault for fault in Fault if any(fault is other for _, other in lost)]
    rows = []
    for run, count in screening.samples.items():
        own = [lost.get((run, fault)) for fault in faults]
        if not any(own):
            continue
        rows.append(
            (
                f"run {run}" + (" (all of it)" if run in screening.runs_left_out else ""),
                str(count),
                *(f"{one.samples} ({_percent(one.share)})" if one else UNKNOWN for one in own),
            )
        )
    return Table(
        "Samples left out",
        ("", "samples", *(cause_name(fault) for fault in faults)),
        tuple(rows),
        "Each counts for the first cause that was found of it.",
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %" if share >= 0.001 else "below 0.1 %"


def findings_table(screening: Screening) -> Table | None:
    """What was found before the fit; None where nothing was."""
    findings = screening.findings
    if not findings:
        return None
    rows = tuple(
        (cause_name(one.fault) if one.fault else "other", one.verdict, one.reason)
        for one in findings
    )
    return Table("Found before the fit", ("", "verdict", "finding"), rows)
