"""Where a round of the blind check keeps its files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "out" / "blind"
POOL = OUT / "pool"
UNIT_SIZES = Path(__file__).with_name("unit_sizes.json")

NOBODY = 65534
PRIVATE = 0o700
"""Rights of the sealed folder: of its owner alone."""


def set_name(number: int) -> str:
    """Folder of a set."""
    return f"set_{number:04d}"


@dataclass(frozen=True)
class Round:
    """One round: sets that are diagnosed once.

    Attributes:
        folder: of everything.
    """

    folder: Path

    @property
    def sealed(self) -> Path:
        """What the diagnosis cannot read."""
        return self.folder / "sealed"

    @property
    def answers(self) -> Path:
        """The truth of every set, written before any of them is made."""
        return self.sealed / "answers.json"

    @property
    def seal(self) -> Path:
        """SHA-256 of the answers, in the clear."""
        return self.folder / "answers.sha256"

    @property
    def ledger(self) -> Path:
        """Which sets have been submitted."""
        return self.folder / "ledger.txt"

    def recorded(self, number: int) -> Path:
        """A set's session."""
        return self.folder / "sets" / set_name(number)

    def made(self, number: int) -> Path:
        """What the generator measured of a set."""
        return self.sealed / "made" / f"{set_name(number)}.json"

    def world(self, number: int) -> Path:
        """A set's reality file."""
        return self.sealed / "worlds" / f"{set_name(number)}.yaml"

    def diagnosis(self, number: int, variant: str = "") -> Path:
        """What the diagnosis said of a set; a variant is one with something switched off."""
        return self.folder / "diagnoses" / (variant or "whole") / f"{set_name(number)}.json"

    def prepare(self) -> None:
        """Make the folders."""
        for folder in (self.made(0).parent, self.world(0).parent, self.recorded(0).parent):
            folder.mkdir(parents=True, exist_ok=True)
        self.sealed.chmod(PRIVATE)
        if os.geteuid() == 0:
            # Root without its powers, as which sets are diagnosed, owns nothing there.
            os.chown(self.sealed, NOBODY, NOBODY)
