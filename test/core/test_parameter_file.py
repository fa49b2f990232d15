from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import FileError
from shoecal_core.parameter_file import load_settings, read_sections, sections_of
from shoecal_core.screening.settings import CalibrationSettings

TEXT = """
/**:
  ros__parameters: {use_sim_time: true}
/**/planner:
  ros__parameters: {stale_s: 0.1, planning: {horizon: 5}}
left:
  planner:
    ros__parameters: {stale_s: 0.2}
/*/model:
  ros__parameters: {}
calibrator:
  ros__parameters: {stale_s: 0.3}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "nodes.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("node", "keys"),
    [
        ("/planner", ["/**", "/**/planner"]),
        ("/left/planner", ["/**", "/**/planner", "left/planner"]),
        ("/far/left/planner", ["/**", "/**/planner"]),
        ("/left/model", ["/**", "/*/model"]),
        ("/model", ["/**"]),
        ("/a/b/model", ["/**"]),
        ("/calibrator", ["/**", "calibrator"]),
        ("/left/calibrator", ["/**"]),
        ("calibrator", ["/**", "calibrator"]),
        ("/planner_2", ["/**"]),
    ],
)
def test_sections_reach_nodes_as_ros_has_it(tmp_path: Path, node: str, keys: list[str]) -> None:
    assert [one.key for one in sections_of(written(tmp_path, TEXT), node)] == keys


def test_settings_by_section_and_by_full_name(tmp_path: Path) -> None:
    for text in ("calibration: {cop_std_m: 0.01}", "calibration.cop_std_m: 0.01"):
        path = written(tmp_path, f"/**/calibrator: {{ros__parameters: {{{text}}}}}")
        found = load_settings(CalibrationSettings, path, "calibrator", "calibration")
        assert found.cop_std_m == 0.01


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ros__parameters: {cop_std_m: 0.01}", "cop_std_m: stands outside 'calibration'"),
        ("ros__parameters: {calibraton: {gain_std: 1}}", "did you mean 'calibration'"),
        ("ros__parameters: {calibraton.gain_std: 1.0}", "did you mean 'calibration'"),
        ("ros__parameters: {calibration.gain_sdt: 1.0}", "calibration.gain_sdt: unknown key"),
        ("ros_parameters: {gain_std: 1}", "ros_parameters: write 'ros__parameters'"),
    ],
)
def test_settings_that_would_be_passed_over(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, f"/**/calibrator: {{{text}}}")
    with pytest.raises(FileError) as caught:
        load_settings(CalibrationSettings, path, "calibrator", "calibration")
    assert words in str(caught.value)


def test_names_of_parameters_are_full(tmp_path: Path) -> None:
    section = read_sections(written(tmp_path, TEXT))[1]
    assert list(section.names()) == ["stale_s", "planning.horizon"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("planner: {ros__parameters: {a: 1}}", ["/**/model", "only of planner", "add this key"]),
        ("planner: {a: 1}", ["planner.a", "expected a mapping"]),
        ("planner: {ros__parameters: {a: 1}, b: 2}", ["planner.b", "unknown key"]),
        ("{}", ["/**/model", "only of none"]),
    ],
)
def test_files_that_set_nothing_are_refused(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(FileError) as caught:
        sections_of(written(tmp_path, text), "/model")
    for word in ["nodes.yaml", *words]:
        assert word in str(caught.value)
