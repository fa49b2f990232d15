from __future__ import annotations

import pytest

from reliability.killed_adapters import REST_S, ROW, Try, judged
from ros.adapters.driver_messages import NoMessagesError


def test_a_robot_whose_adapter_is_killed_comes_to_rest() -> None:
    """By set points, of which the driver keeps the last."""
    try:
        found = ROW.run(0, 1, 0, lambda _: None)
    except NoMessagesError as error:
        pytest.skip(str(error))
    assert (found.tried, found.failed) == (1, 0), found.worst
    assert not any(found.counts.values())


def test_a_controller_may_go_on_to_its_end() -> None:
    rests, goes_on, never = (
        Try(kind, rest_s, allowed_s, 4.0, "")
        for kind, rest_s, allowed_s in (
            ("nao_lola", 0.1, REST_S),
            ("topic", 20.0, 30.0),
            ("naoqi", 20.0, REST_S),
        )
    )
    assert [one.went_on for one in (rests, goes_on, never)] == [False, True, False]
    result = judged([rests, goes_on], "")
    assert (result.tried, result.failed, *result.counts.values()) == (2, 0, 1)
    assert judged([rests, never], "").failed == 1
    assert (judged([], "why").tried, judged([], "why").failed) == (1, 1)
