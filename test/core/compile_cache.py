"""Compiling with a cache and compilers of a test's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core import compiled


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of the libraries, not made yet; nothing has been said or compiled."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv("SHOECAL_COMPILE", raising=False)
    monkeypatch.setattr(compiled, "_interpreted", {})
    monkeypatch.setattr(compiled, "_compiled", set())
    return tmp_path / "cache" / "shoecal"


def program(path: Path, script: str) -> str:
    """A compiler of one's own: its name, for CC."""
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o700)
    return str(path)


def libraries(cache: Path) -> list[Path]:
    """Whatever is in the cache, also what was left behind."""
    return sorted(cache.iterdir()) if cache.is_dir() else []
