from __future__ import annotations

import pytest

from ros.bodies import ROOT
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.files import Fields, read_yaml
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.settings import Settings, describe
from shoecal_ros.calibrator.calibrator_base import CalibratorSettings
from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.common.frames import FrameSettings
from shoecal_ros.common.robot_files import RobotFiles

PATH = ROOT / "config/nodes/calibrator.yaml"
NODE = (RobotFiles, FrameSettings, CalibratorSettings, JobSettings)
SECTIONS: dict[type[Settings], str] = {
    CalibrationSettings: "calibration",
    Tolerances: "tolerances",
    DiagnosisSettings: "diagnosis",
}


def parameters() -> Fields:
    return read_yaml(PATH).mapping("/**/calibrator").mapping("ros__parameters")


def test_the_file_holds_every_parameter_and_no_other() -> None:
    block = parameters()
    names = [entry.name for settings in NODE for entry in describe(settings)]
    assert sorted(block.keys()) == sorted([*names, *SECTIONS.values()])
    for settings, section in SECTIONS.items():
        own = [entry.name for entry in describe(settings)]
        assert sorted(block.mapping(section).keys()) == sorted(own)


@pytest.mark.parametrize("settings", [*NODE, *SECTIONS])
def test_each_stands_at_its_default_with_unit_and_meaning(settings: type[Settings]) -> None:
    block, indent, lines = parameters(), " " * 4, PATH.read_text().splitlines()
    if settings in SECTIONS:
        section = SECTIONS[settings]
        block, indent = block.mapping(section), " " * 6
        lines = lines[lines.index(f"    {section}:") :]
    for entry in describe(settings):
        assert entry.checked(block.value(entry.name)) == entry.default
        line = next(line for line in lines if line.startswith(f"{indent}{entry.name}: "))
        assert entry.doc in line
        assert not entry.unit or f"[{entry.unit}]" in line
