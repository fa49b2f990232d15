"""Names that anybody may have given, fit to stand in a line for a person."""

from __future__ import annotations

from shoecal_core.errors import one_line

LONGEST_NAME = 100
"""Letters."""


def short_name(name: str) -> str:
    """In one printable line; cut off where it is too long."""
    reported = one_line(name[:LONGEST_NAME])
    return reported if len(name) <= LONGEST_NAME else f"{reported}..."
