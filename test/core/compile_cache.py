"""What tests of compiled functions share."""

from __future__ import annotations

from pathlib import Path


def program(path: Path, script: str) -> str:
    """A compiler of one's own: its name, for CC."""
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o700)
    return str(path)


def libraries(folder: Path) -> list[Path]:
    """Whatever is in the cache, also what was left behind."""
    return sorted(folder.iterdir()) if folder.is_dir() else []
