"""What data leave open, in words."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.planning.supports.identifiability import Identifiability, WeakDirection
from shoecal_core.report.weak_table import known_text, weak_table


@pytest.mark.parametrize(
    ("uncertainties", "words"),
    [
        ([0.4], "uncertain by 40 %"),
        ([9499.75], "no information in these data"),
        ([0.4, np.inf], "2 directions, uncertain by 40 % or more"),
    ],
)
def test_how_well_directions_are_known(uncertainties: list[float], words: str) -> None:
    assert known_text(uncertainties) == words


def test_alike_directions_are_one_row() -> None:
    weak = tuple(WeakDirection("the offsets", one) for one in (0.4, 2.0))
    table = weak_table(Identifiability(np.ones(3), 12, 14, weak))
    assert table is not None
    assert table.rows == (("the offsets", "2 directions, uncertain by 40 and 200 %"),)
    assert weak_table(Identifiability(np.ones(3), 14, 14, ())) is None
