"""Lines and tables for a terminal."""

from __future__ import annotations

import numpy as np

from core.estimation.standing import calibration
from core.shoe import shoes
from shoecal_core.cli.tables import reason_lines
from shoecal_core.shoe.wrench import ChannelParameters


def test_a_level_is_told_once_a_line() -> None:
    shoe = shoes.shoe("nao_shoe")
    plain = ChannelParameters(np.ones(len(shoe.names)), np.zeros(len(shoe.names)))
    reasons = ("FAIL: a foot slipped: hold it", "WARN: odd", "as it is")
    made = calibration(shoe, plain, verdict="FAIL", reasons=reasons)
    assert [line.plain for line in reason_lines(made)] == [
        "FAIL: a foot slipped: hold it", "WARN: odd", "FAIL: as it is"
    ]  # fmt: skip
