"""Some mutants of every kind of file; what is refused and what is loaded is judged by the rows."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from reliability.loading import Target
from reliability.mutated_calibrations import CalibrationFile
from reliability.mutated_recordings import RunFile
from reliability.mutated_serial_logs import SerialLog
from reliability.mutated_sessions import SessionFolder
from reliability.mutated_urdfs import UrdfFiles
from reliability.mutated_yaml import YamlFiles
from reliability.row import Row
from reliability.tree_mutations import mutate_yaml
from shoecal_core.errors import FileError, ShoecalError, error_code

SEED = 1
KINDS = (CalibrationFile, RunFile, SerialLog, SessionFolder, UrdfFiles, YamlFiles)


@pytest.mark.parametrize(
    ("module", "count"),
    [
        ("mutated_recordings", 60),
        ("mutated_yaml", 60),
        ("mutated_urdfs", 60),
        ("mutated_calibrations", 60),
        ("mutated_sessions", 60),
        ("mutated_serial_logs", 300),
    ],
)
def test_a_mutant_is_refused_or_loaded_as_it_stands(module: str, count: int) -> None:
    row: Row = importlib.import_module(f"reliability.{module}").ROW
    done: list[int] = []
    found = row.run(0, count, SEED, done.append)
    assert (found.tried, found.failed) == (count, 0), found.worst
    assert done[-1] == count
    assert "MiB" in found.worst


@pytest.mark.parametrize("kind", KINDS)
def test_a_refusal_tells_what_is_wrong_by_its_code(kind: type[Target]) -> None:
    assert kind.codes
    catch_all = {error_code(one) for one in (ShoecalError, FileError)}
    assert not kind.codes & catch_all


def test_a_number_that_no_float_holds_is_scaled_too(tmp_path: Path) -> None:
    told = [
        mutate_yaml(b"mass: 1" + 400 * b"0", np.random.default_rng(seed), tmp_path)[0]
        for seed in range(100)
    ]
    assert any("scaled" in what for what in told)
