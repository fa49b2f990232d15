"""Effects of the simulated robot are found with the size and the sign that it was given.

The simulation knows nothing of the diagnosis: each effect is physics there, or another law.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from core.diagnosis.drawn import part
from shoecal_core import cli
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.result import Size
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.sizes import sizes
from shoecal_core.diagnosis.workspace import make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session

WORLDS = {
    "feet": """
  - {effect: foot_placement, location: [right], dx_m: 0.005, dy_m: -0.004, dtheta_rad: 0.04}
  - {effect: floor_tilt, about_x_rad: 0.012, about_y_rad: -0.008}
  - {effect: payload, location: [base], mass_kg: 0.2}
  - {effect: latency, location: [left], delay_s: 0.08}
""",
    "ground": """
  - {effect: soft_ground, location: [left], compliance_rad_per_nm: 0.01}
  - {effect: link_com, location: [base], x_m: 0.01, y_m: -0.008, z_m: 0.0}
""",
    "legs": """
  - {effect: joint_compliance, location: [LKneePitch], compliance_rad_per_nm: 0.012}
  - {effect: cell_position, location: [right/front_left], x_m: 0.006, y_m: -0.005}
""",
}
TRUTHS: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "feet": {
        "foot_placement (right)": {"dx": 0.005, "dy": -0.004, "dtheta": 0.04},
        "floor_tilt": {"about_x": 0.012, "about_y": -0.008},
        "payload (base_link)": {"mass": 0.2},
        "latency (left)": {"delay": 0.08},
    },
    "ground": {
        "soft_ground (left)": {"compliance": 0.01},
        "link_com (base_link)": {"x": 0.01, "y": -0.008, "z": 0.0},
    },
    "legs": {
        "joint_compliance (LKneePitch)": {"compliance": 0.012},
        "cell_position (right/front_left)": {"x": 0.006, "y": -0.005},
    },
}
RUNS = (1, 2, 3, 4)
CONFIG = Path(__file__).resolve().parents[3] / "config"
SETTINGS = DiagnosisSettings()


@pytest.mark.parametrize("world", WORLDS)
def test_sizes_are_those_of_the_physics(world: str, tmp_path: Path) -> None:
    """Within their interval, or by less than 0.4: springs and plates are no straight lines."""
    reality = tmp_path / "reality.yaml"
    perfect = (CONFIG / "realities" / "perfect.yaml").read_text()
    reality.write_text(perfect + "effects:" + WORLDS[world])
    words = [
        "simulate", CONFIG / "robots" / "nao.yaml", CONFIG / "shoes" / "nao_shoe.yaml",
        "--reality", reality, "--motions", "landmarks,reversed,unload_left,unload_right",
        "--rate", "50", "--seed", "4", "--out", tmp_path / "session",
    ]  # fmt: skip
    assert cli.main([str(word) for word in words]) == 0
    found = fitted(tmp_path / "session", tuple(TRUTHS[world]))
    for label, truth in TRUTHS[world].items():
        for name, true in truth.items():
            low, high = found[label][name].ci95
            near = abs(found[label][name].value - true) < 0.4 * abs(true)
            assert near or low <= true <= high, f"{label}: {found[label]}"


def fitted(folder: Path, labels: tuple[str, ...]) -> Mapping[str, Mapping[str, Size]]:
    """Sizes of all that is there, fitted together."""
    samples = load_data(Session.open(folder), RUNS).whole_samples(SETTINGS)
    signal_model = make_signal_model(samples, first_parameters(samples, RUNS), SETTINGS)
    wanted = {label.split(" ")[0] for label in labels}
    effects = [effect for effect in EFFECTS if effect.identifier in wanted]
    workspace = make_workspace(signal_model, effects, RUNS, (), SETTINGS, Tolerances())
    scored = workspace.scorer.score([part(workspace, label) for label in labels])
    return {label: sizes(workspace, scored, index) for index, label in enumerate(labels)}
