"""Whatever is bad in a diagnostic says what to do, by the texts of the sources."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from ros.cures import names_a_cure
from ros.sayings import Source

SOURCES = Path(__file__).parents[2] / "shoecal_ros/shoecal_ros"
FILES = sorted(SOURCES.rglob("*.py"))
ERRORS_IN = ("adapters", "calibrator", "inputs")
"""What is raised there is told in diagnostics, as it is."""
WORDED = {"NameNotFoundError", "PackageMissingError"}
"""Take no message, but what it is about."""
PASSED_ON = {
    "adapters/adapter.py": {
        "reported.message",  # of problems, which are looked at where they are made
        "self._refusal",  # why a trajectory was refused: the text of an error
        "missing",  # of a controller
        "str(self.joints.problem)",
    },
    "calibrator/calibration_server.py": {"reported"},  # of an error
    "calibrator/calibration_store.py": {
        "reported",  # of an error
        "f'no whole calibration: {error.field} {error.problem}'",
    },
    "calibrator/diagnosis_server.py": {"reported"},  # why it ended
    "calibrator/diagnosis_job.py": {"str(error)"},
    "calibrator/job.py": {"str(error)", "problem.message", "node.recorder.problem"},
    "calibrator/recorder.py": {"self.problem"},
    "calibrator/rezeroing.py": {"problem.message"},
    "calibrator/run_series.py": {
        "str(error)",
        "str(problem)",
        "f'{what}: {result.message}'",  # of whoever was asked to move the robot
    },
    "calibrator/self_calibration.py": {"reported"},  # why it ended
    "common/codes.py": {"'; '.join(map(str, reported))"},
    "common/health.py": {"message"},
    "common/graph_monitor.py": {"reported.message"},
    "nodes/calibrator.py": {"UNCALIBRATED"},  # of another module
    "nodes/simulator.py": {"self._refused"},
    "planner/watched.py": {"reason.message"},
    "serial/serial_source.py": {"found.message", "f'serial port {self._name}: {message}'"},
    "serial/watch.py": {"f'{reported}: {self._fault.text}'"},  # of a decoder
    "simulator/body_publishers.py": {"problem.message"},
}
"""Expressions whose cure is somebody else's."""


def message(call: ast.Call, *, errors: bool) -> ast.expr | None:
    """What a call tells that is bad; None where it tells nothing, or nothing bad."""
    name, words = ast.unparse(call.func).rpartition(".")[2], call.args
    if name in {"Problem", "StopReason", "_reported"} and len(words) > 1:
        return words[1] if name != "_reported" or "code" in ast.unparse(words[0]).lower() else None
    if name == "Condition":
        return words[1] if ast.unparse(words[0]) != "Level.OK" else None
    if name == "report" and len(words) > 2:
        return words[2] if ast.unparse(words[1]) != "Level.OK" else None
    if errors and name.endswith("Error") and words and name not in WORDED:
        return words[-1]
    return None


def bad(file: Path) -> Iterator[tuple[str, list[str]]]:
    """Expressions of a file that tell something bad, and all they may say."""
    source, errors = Source(file), file.parent.name in ERRORS_IN
    for call in source.calls():
        if (reported := message(call, errors=errors)) is not None:
            yield ast.unparse(reported), [text for text in source.texts(reported) if text]


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(SOURCES)))
def test_what_is_bad_comes_with_its_cure(file: Path) -> None:
    passed_on = PASSED_ON.get(str(file.relative_to(SOURCES)), set())
    without = {
        expression: lost
        for expression, texts in bad(file)
        if (lost := [text for text in texts if not names_a_cure(text)])
    }
    assert {key: text for key, text in without.items() if key not in passed_on} == {}
    assert passed_on <= set(without), "what is passed on has a cure of its own by now"


def test_there_is_much_to_look_at() -> None:
    assert sum(len(list(bad(file))) for file in FILES) > 80
    assert set(PASSED_ON) <= {str(file.relative_to(SOURCES)) for file in FILES}


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("no voltages yet; start shoe_driver", True),
        ("left/heel gives nothing: check cable, clamp and board", True),
        ("bytes.bin: replayed to its end", False),
        ("the controller gave up with code 3: no reason told", False),
        ("it is started by itself", False),
    ],
)
def test_a_cure_is_a_part_that_says_what_to_do(text: str, cure: bool) -> None:
    assert names_a_cure(text) == cure
