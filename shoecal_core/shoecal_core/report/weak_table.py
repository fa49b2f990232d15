"""What data leave open, for a page."""

from __future__ import annotations

import math
from collections.abc import Sequence

from shoecal_core.planning.supports.identifiability import WeakDirection
from shoecal_core.report.page import Table


def weak_table(weak: Sequence[WeakDirection], note: str = "") -> Table | None:
    """Directions that data leave open; None without any."""
    if not weak:
        return None
    rows = tuple((one.words, _known_to(one.uncertainty)) for one in weak)
    return Table("Left open by the data", ("direction", "what is known of it"), rows, note)


def _known_to(uncertainty: float) -> str:
    if not math.isfinite(uncertainty):
        return "nothing"
    return f"uncertain by {100.0 * uncertainty:.0f} %"
