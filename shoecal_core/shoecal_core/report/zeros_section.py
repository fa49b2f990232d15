"""What feet read in the air, as a section of a report."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.report.page import Group, Section, Table
from shoecal_core.report.quantities import UNKNOWN, quantity, uncertain
from shoecal_core.samples.zeros import ZeroFigures


def zeros_section(zeros: Sequence[ZeroFigures]) -> tuple[Section, ...]:
    """One line a run and foot; no section without any."""
    if not zeros:
        return ()
    rows = tuple(
        (
            f"run {one['run']}",
            one["foot"],
            uncertain(one["fz_n"], 0.5 * (one["ci95"][1] - one["ci95"][0]), "N"),
            quantity(one["left_n"], "N", 1) if "left_n" in one else UNKNOWN,
        )
        for one in zeros
    )
    text = (
        "A foot in the air carries nothing: what it reads is its zero. By the gains of the data "
        "sheets without offsets; where there are none, by the calibration. Zeros that change from "
        "run to run ask for each run's own (--rezero)."
    )
    header = ("", "foot", "vertical force in the air (95 %)", "left by the calibration")
    table = Table("Zeros, run by run", header, rows)
    return (Section("Feet in the air", (Group(tables=(table,)),), text),)
