"""What a screening left out, as a table for a terminal."""

from __future__ import annotations

from collections import Counter

from rich.table import Table

from shoecal_core.cli.tables import new_table
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening


def screening_table(screening: Screening) -> Table:
    """One line a run that lost something: its samples, and how many of them each fault cost."""
    lost = Counter[tuple[int, Fault]]()
    for one in screening.left_out:
        lost[one.run, one.fault] += one.samples
    faults = [fault for fault in Fault if any(fault is other for _, other in lost)]
    table = new_table("Samples left out")
    for name in ("run", "samples", *(fault.value.replace("_", " ") for fault in faults)):
        table.add_column(name, justify="right")
    for run, count in screening.samples.items():
        cells = [lost[run, fault] for fault in faults]
        if any(cells):
            texts = [f"{one} ({one / count:.1%})" if one else "-" for one in cells]
            table.add_row(str(run), str(count), *texts)
    return table
