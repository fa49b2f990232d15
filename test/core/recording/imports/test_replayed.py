"""Two series of stamps that come in turns in one topic."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.recording.imports.replayed import describe_replayed, replayed

LATE_S = np.random.default_rng(2).exponential(0.004, 300)
"""Of messages of one sender."""


def test_one_sender() -> None:
    assert replayed(LATE_S.tolist()) is None
    assert replayed([]) is None


def test_a_clock_that_is_set_while_it_records() -> None:
    assert replayed((LATE_S + np.where(np.arange(300) < 140, 0.0, 37.0)).tolist()) is None


def test_single_messages_that_come_late() -> None:
    late = LATE_S.copy()
    late[[20, 180]] = 3.0
    assert replayed(late.tolist()) is None


@pytest.mark.parametrize(
    ("apart", "said"), [(90.0, "90.0 s apart"), (7.0 * 86400.0, "7.0 days apart")]
)
def test_an_old_bag_that_was_played(apart: float, said: str) -> None:
    turns = np.arange(300) % 3 == 0
    found = replayed((LATE_S + apart * turns).tolist())
    assert found is not None
    assert found == pytest.approx(apart, abs=0.01)
    assert said in describe_replayed(found)
