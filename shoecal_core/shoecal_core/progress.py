"""How long work says how far it has come."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Called with what is being done, and the share done (0 to 1)."""


def no_progress(_text: str, _share: float) -> None:
    """For work without anyone to report to."""
