from __future__ import annotations

import signal

import pytest

from shoecal_ros.common.end_asked import EndAsked


def test_only_a_second_interrupt_ends_at_once() -> None:
    asked = EndAsked()
    try:
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert asked.to_end
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        asked.close()
