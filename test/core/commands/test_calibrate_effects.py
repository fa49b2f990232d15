"""`shoecal calibrate --effects`: what is chosen of a diagnosis is told everywhere alike."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from shoecal_core.diagnosis.result import Cause, Diagnosis, Gap, Shrink, Size, Verdict

Run = Callable[..., tuple[int, str, str]]
NOTHING = Shrink(0.0, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))


def written(path: Path, verdict: Verdict, probability: float) -> Path:
    """A diagnosis of a cell 2 cm beside its place, where it is not."""
    cause = Cause(
        "cell_position", "load_cell", ("left/toe",), probability,
        {"x": Size(0.02, "m", (0.018, 0.022))}, None, NOTHING, 0.0,
    )  # fmt: skip
    diagnosis = Diagnosis(
        verdict, Gap(0.0, 0.0, 0.0, 0.0), (), (cause,), (), (), (), (), None, (1, 2), (3,), (),
        "odd_biped", "odd_shoe",
    )  # fmt: skip
    path.write_text(json.dumps(diagnosis.to_json()))
    return path


@pytest.mark.parametrize(
    ("verdict", "probability", "fitted"), [("ambiguous", 0.3, False), ("explained", 0.95, True)]
)
def test_what_is_chosen_is_told(
    shoecal: Run,
    simulated: Path,
    tmp_path: Path,
    verdict: Verdict,
    probability: float,
    fitted: bool,
) -> None:
    figures, report = tmp_path / "figures.json", tmp_path / "report.html"
    code, out, error = shoecal(
        "calibrate", simulated, "--train", "1,2", "--test", "3",
        "--effects", written(tmp_path / "diagnosis.json", verdict, probability),
        "--out", tmp_path / "c.yaml", "--json", figures, "--report", report,
    )  # fmt: skip
    assert code == 0, error
    choice = json.loads(figures.read_text())["effects_choice"]
    label = "cell_position (left/toe)"
    assert choice["fitted"] == ([label] if fitted else [])
    assert choice["left_out"] == ([] if fitted else [label])
    assert [one["effects"] for one in choice["tried"]] == ([] if fitted else [[label]])
    (line,) = [line.strip() for line in out.splitlines() if "found effects" in line]
    assert line.startswith(f"found effects that are fitted: {label if fitted else 'none'}")
    assert f"{line[0].upper()}{line[1:]}." in report.read_text()
