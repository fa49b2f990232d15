"""Which sessions belong to which inputs."""

from __future__ import annotations

from pathlib import Path

import pytest

import accuracy_sessions
from accuracy_sessions import MOTIONS, REALITIES, Case, cases
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workspace import config_dir


def test_every_reality_is_a_file_with_inputs_of_its_own() -> None:
    for reality in REALITIES:
        load_reality(config_dir() / "realities" / "default.yaml", Case(reality, "paper", 1).changes)
    assert len({Case(reality, "paper", 1).inputs for reality in REALITIES}) == len(REALITIES)


def test_noise_is_all_that_tells_noisy_realities_from_what_they_are_judged_on() -> None:
    default = config_dir() / "realities" / "default.yaml"
    plain = load_reality(default)
    for reality in accuracy_sessions.NOISY:
        case = Case(reality, "standard", 3)
        assert case.quiet == Case("default", "standard", 3)
        rules = load_reality(default, case.changes)
        assert rules.cells != plain.cells
        for section in ("body", "joints", "servo", "imu", "shoes", "floor", "effects", "step_s"):
            assert getattr(rules, section) == getattr(plain, section)
    assert Case("other_laws", "standard", 3).quiet.reality == "other_laws"


def test_a_session_of_other_inputs_counts_as_not_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = Case("noisy", "standard", 1, tmp_path)
    case.folder.mkdir(parents=True)
    assert not case.made
    case.folder.with_suffix(".inputs").write_text(case.inputs)
    assert case.made
    monkeypatch.setattr(Case, "inputs", "of another reality")
    assert not case.made
    assert len(cases(REALITIES, tuple(MOTIONS), range(3), tmp_path)) == 3 * 2 * len(REALITIES)
