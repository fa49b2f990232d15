"""Drafts that several tests look at."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from core.shoe.shoes import ROOT
from shoecal_core.drafting.draft import Draft, draft_robot

ROBOTS = ROOT / "config/robots"


@cache
def draft(name: str) -> Draft:
    """Of a robot that comes with shoecal."""
    return draft_robot(ROBOTS / f"{name}.urdf", name)


def edited(folder: Path, name: str, pattern: str, replacement: str, count: int = 0) -> Path:
    """A copy of a robot's URDF with something else in it."""
    text, found = re.subn(
        pattern, replacement, (ROBOTS / f"{name}.urdf").read_text(), count=count, flags=re.DOTALL
    )
    assert found
    file = folder / f"{name}.urdf"
    file.write_text(text)
    return file
