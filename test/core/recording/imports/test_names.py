from __future__ import annotations

import pytest

from shoecal_core.recording.imports.names import matched_names, without_prefix


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("l_ankle", "l_ankle"),
        ("/l_ankle", "l_ankle"),
        ("nao6/l_ankle", "l_ankle"),
        ("/lab/nao6/l_ankle", "l_ankle"),
        ("nao6_l_ankle", "l_ankle"),
        ("left_l_ankle", None),
        ("nao6/knee", None),
    ],
)
def test_prefixes(name: str, known: str | None) -> None:
    assert without_prefix(name, {"ankle", "l_ankle"}) == known


def test_names_are_matched_once() -> None:
    found = ["nao6_LKneePitch", "l_knee_pitch", "nao6_LHipRoll", "lhip_yaw_joint"]
    known = ["LKneePitch", "LHipRoll", "LHipYaw"]
    assert matched_names(found, known) == {
        "nao6_LHipRoll": "LHipRoll", "lhip_yaw_joint": "LHipYaw"
    }  # fmt: skip
