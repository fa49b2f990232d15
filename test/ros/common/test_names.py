from __future__ import annotations

from shoecal_ros.common.names import LONGEST_NAME, short_name


def test_a_name_is_told_as_it_is() -> None:
    assert short_name("20261122T034512123") == "20261122T034512123"
    assert short_name("") == ""


def test_anybody_s_text_is_one_short_printable_line() -> None:
    reported = short_name("one\ntwo\x1b[31m" + 5000 * "x")
    assert reported.isprintable()
    assert reported.startswith("one two")
    assert len(reported) <= LONGEST_NAME + 3
    assert reported.endswith("...")
