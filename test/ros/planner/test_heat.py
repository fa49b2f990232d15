from __future__ import annotations

from shoecal_ros.planner import heat

TOLD = {"LKneePitch": 66.0, "RKneePitch": 70.5, "HeadYaw": 30.0}


def test_the_hottest_joint_is_named() -> None:
    assert heat.hottest(TOLD) == ("RKneePitch", 70.5)
    assert heat.too_hot(TOLD, 68.0) == "joint 'RKneePitch' is at 70 degC (limit 68 degC)"
    assert heat.too_hot(TOLD, 71.0) == ""
    assert heat.too_hot({"HeadYaw": 68.0}, 68.0), "the limit itself is too hot"


def test_the_margin_is_told() -> None:
    assert "'RKneePitch' at 70 degC, 10 degC below" in heat.margin(TOLD, 80.0)
    assert "not watched" in heat.margin({}, 80.0)


def test_nothing_known_is_no_concern() -> None:
    assert heat.hottest({}) is None
    assert heat.too_hot({}, 0.0) == ""
