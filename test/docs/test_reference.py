"""docs/reference is what the code makes of it."""

from __future__ import annotations

import subprocess
import sys

from docs.pages import ROOT


def test_it_is_up_to_date() -> None:
    # A process of its own: it starts every node.
    result = subprocess.run(
        [sys.executable, ROOT / "scripts/make_reference.py", "--check"],
        capture_output=True, text=True, timeout=240, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
