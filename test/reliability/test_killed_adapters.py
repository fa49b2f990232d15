from __future__ import annotations

import pytest

from reliability.killed_adapters import ROW
from ros.adapters.driver_messages import NoMessagesError


def test_a_robot_whose_adapter_is_killed_comes_to_rest() -> None:
    """By set points, of which the driver keeps the last."""
    try:
        found = ROW.run(0, 1, 0, lambda _: None)
    except NoMessagesError as error:
        pytest.skip(str(error))
    assert (found.tried, found.failed) == (1, 0), found.worst
