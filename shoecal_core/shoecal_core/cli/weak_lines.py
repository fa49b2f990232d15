"""What data leave open, for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.planning.supports.identifiability import Identifiability


def weak_lines(found: Identifiability) -> list[str]:
    """Directions that are not identified, those alike on one line, with what is known of them."""
    return [
        f"not identified: {words} ({_known(uncertainties)})"
        for words, uncertainties in found.weak_by_words.items()
    ]


def _known(uncertainties: Sequence[float]) -> str:
    count = f"{len(uncertainties)} directions, " if len(uncertainties) > 1 else ""
    finite = [f"{100.0 * one:.0f}" for one in uncertainties if np.isfinite(one)]
    if not finite:
        return f"{count}no information in these data"
    rest = " % or more" if len(finite) < len(uncertainties) else " %"
    return f"{count}uncertain by {' and '.join(finite)}{rest}"
