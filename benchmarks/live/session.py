"""A recorded session to solve meanwhile."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from shoecal_core.workspace import config_dir

NAME = "recorded"
SUPPORTS = 3


def make(folder: Path) -> None:
    """A simulated session in a new folder."""
    config = config_dir()
    command = [
        str(Path(sys.executable).with_name("shoecal")), "simulate",
        str(config / "robots" / "nao.yaml"), str(config / "shoes" / "nao_shoe.yaml"),
        "--supports", str(SUPPORTS), "--seed", "1", "--out", str(folder),
    ]  # fmt: skip
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
