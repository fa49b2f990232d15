"""Which benchmarks `make evidence` runs, and what it forgets before."""

from __future__ import annotations

from pathlib import Path

import evidence

REFERENCE = {"motion_menu"}
"""Benchmarks whose table is no measurement: docs/reference."""


def test_every_benchmark_with_a_page_is_run() -> None:
    folder = Path(evidence.__file__).parent
    # two of them write their pages in packages of their own
    writers = {"blind_check", "faults"} | {
        file.stem for file in folder.glob("*.py") if "write_section(" in file.read_text()
    }
    assert writers - {"pages"} == set(evidence.ORDER) | evidence.BY_HAND | REFERENCE


def test_results_of_other_code_are_forgotten(tmp_path: Path) -> None:
    kept = tmp_path / "seeds" / "result.json"
    for version, before in (("1", False), ("1", True), ("2", False)):
        evidence.forget_older(tmp_path, version)
        assert kept.exists() == before
        kept.parent.mkdir(exist_ok=True)
        kept.touch()
