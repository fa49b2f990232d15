from __future__ import annotations

import math

from shoecal_ros.planner.silence import Silence, silent


def test_who_told_something_must_go_on() -> None:
    silence = Silence({"shoe/voltages": 0.1, "imu": math.inf}, 0.5)
    assert silence.look({"shoe/voltages": 0.3, "imu": math.inf}) == ""
    assert silence.look({"shoe/voltages": 0.7, "imu": 0.1}) == "shoe/voltages (0.7 s)"


def test_who_was_silent_before_is_no_concern() -> None:
    silence = Silence({"imu": 2.0}, 0.5)
    assert silence.look({"imu": 9.0}) == ""


def test_a_source_that_is_gone_altogether() -> None:
    silence = Silence({"imu": 0.0, "shoe/state": 0.0}, 0.5)
    assert silence.look({"imu": 1.0}) == "imu (1.0 s), shoe/state"


def test_many_sources_are_told_in_one_short_line() -> None:
    silence = Silence({f"motor {number}": 0.0 for number in range(5)}, 0.5)
    assert silence.look({}) == "motor 0, motor 1, motor 2, 2 more"


def test_all_well_is_told_by_nothing() -> None:
    assert silent({"imu": 0.1}, 0.5) == ""
