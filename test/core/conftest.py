"""What tests of the core share."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core import compiled


@pytest.fixture
def library_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A test's own folder of compiled libraries, not made yet; nothing was compiled or said."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv("SHOECAL_COMPILE", raising=False)
    monkeypatch.setattr(compiled, "_interpreted", {})
    monkeypatch.setattr(compiled, "_compiled", set())
    return tmp_path / "cache" / "shoecal"
