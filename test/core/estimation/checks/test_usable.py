"""Each finding on its fault, and none on clean data."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.estimation import synthetic
from core.planning.bodies import load_body
from core.shoe import shoes
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.estimation.checks.usable import (
    GAIN_RATIO,
    check_directions,
    check_expected,
    check_gains,
    check_robot,
    check_soles,
)
from shoecal_core.estimation.fit import self_calibrate
from shoecal_core.estimation.freed_gears import FreedGears
from shoecal_core.estimation.initial_guess import InitialGuess
from shoecal_core.estimation.joint_fit import FittedDeviation
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.identifiability import (
    Identifiability,
    WeakDirection,
    identifiability,
    total_information,
)
from shoecal_core.planning.supports.observability import Visit
from shoecal_core.report.weak_table import weak_lines
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.clocks.time_offsets import describe_time_offset
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding, judge, list_reasons, split_reason
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SETTINGS = CalibrationSettings()


@pytest.fixture
def runs(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> list[Stance]:
    return synthetic.stances(shoe, truth, rng)


def test_clean_data_pass_every_check(shoe: Shoe, runs: list[Stance]) -> None:
    stages = self_calibrate(shoe, runs, SETTINGS)
    findings = [
        *describe_time_offset(0.049),
        *check_gains(shoe, stages.guess.polarity, stages.parameters),
    ]
    assert findings == []
    assert judge(findings).verdict == "PASS"


# ---- gains ------------------------------------------------------------------------------------


def guess(shoe: Shoe, parameters: ChannelParameters) -> InitialGuess:
    return InitialGuess(parameters, shoe.polarity, 25.0, 0.0)


@pytest.mark.parametrize(
    ("factor", "reason"),
    [
        (-1.0, "wrong sign"),
        (1.01 * GAIN_RATIO, "has gain"),
        (0.99 / GAIN_RATIO, "has gain"),
        (1e-9, "has gain"),
    ],
)
def test_a_gain_unlike_the_others(shoe: Shoe, factor: float, reason: str) -> None:
    clean = ChannelParameters(25.0 * shoe.polarity.astype(float), np.zeros(len(shoe.names)))
    for channel, name in enumerate(shoe.names):
        gain = clean.gain.copy()
        gain[channel] *= factor
        (finding,) = check_gains(
            shoe, guess(shoe, clean).polarity, ChannelParameters(gain, clean.offset)
        )
        assert finding.verdict == "FAIL"
        assert finding.reason.startswith(name)
        assert reason in finding.reason
    assert check_gains(shoe, guess(shoe, clean).polarity, clean) == []


def test_a_cell_of_wrong_polarity_in_the_shoe_file_is_found_by_the_fit(
    truth: ChannelParameters, shoe: Shoe, rng: np.random.Generator
) -> None:
    turned = ChannelParameters(
        np.where(np.arange(len(truth.gain)) == 1, -truth.gain, truth.gain), truth.offset
    )
    runs = synthetic.stances(shoe, turned, rng)
    stages = self_calibrate(shoe, runs, SETTINGS)
    findings = check_gains(shoe, stages.guess.polarity, stages.parameters)
    assert [finding.reason.split()[0] for finding in findings] == [shoe.names[1]]
    assert judge(findings).verdict == "FAIL"


def test_forces_and_torques_are_compared_with_their_own_kind() -> None:
    origin = [0.0, 0.0, 0.1]
    shoe = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    gain = np.where(shoe.torque, 0.02, 1.0)
    parameters = ChannelParameters(gain, np.zeros(10))
    known = InitialGuess(parameters, shoe.polarity, np.nan, np.nan)
    assert check_gains(shoe, known.polarity, parameters) == []
    gain = gain.copy()
    gain[3] = 1.0
    (finding,) = check_gains(shoe, known.polarity, ChannelParameters(gain, np.zeros(10)))
    assert finding.reason.startswith("left/mx has gain 1, the others about 0.02")


# ---- clocks -----------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [1.5, -1.5])
def test_clocks_further_apart_than_is_looked_for_fail(offset: float) -> None:
    (finding,) = describe_time_offset(offset)
    assert finding.verdict == "FAIL"
    assert "not corrected" in finding.reason


def test_directions_that_no_support_could_fix_are_no_finding() -> None:
    told = Identifiability(np.ones(3), 14, 14, (WeakDirection("the gain of left/fx", 5.0),))
    assert check_directions(told, None) == []
    assert check_directions(dataclasses.replace(told, rank=13), None) != []


@pytest.mark.parametrize(("offset", "told"), [(0.06, "late by 60 ms"), (-0.12, "early by 120 ms")])
def test_clocks_that_are_far_apart(offset: float, told: str) -> None:
    (finding,) = describe_time_offset(offset)
    assert finding.verdict == "WARN"
    assert told in finding.reason
    assert "one clock" in finding.reason


# ---- rank and verdict -------------------------------------------------------------------------


def test_missing_directions() -> None:
    """Two supports without a difference in yaw: named, with a support that cures it."""
    body = load_body("nao")
    settings = PlannerSettings()
    straight = [
        Visit.expected(body.robot, DoubleSupport(dx, -0.104, 0.0), settings) for dx in (0.0, 0.05)
    ]
    known = total_information(body.robot, body.shoe, straight)
    told = identifiability(body.robot, body.shoe, known, settings)
    assert told.weak
    (finding,) = check_directions(told, None)
    assert finding.verdict == "WARN"
    assert f"identify {told.rank} of {told.possible} directions" in finding.reason
    assert "other yaws" in finding.reason
    (finding,) = check_directions(told, DoubleSupport(0.0, -0.12, 0.4))
    assert "dy -0.12 m, dtheta 0.4 rad" in finding.reason
    (finding,) = check_directions(told, DoubleSupport(0.0, -0.12, 0.4), cure=False)
    assert "add a double support" not in finding.reason
    assert check_directions(dataclasses.replace(told, weak=()), None) == []
    many = tuple(WeakDirection(f"direction {number}", np.inf) for number in range(9))
    (finding,) = check_directions(dataclasses.replace(told, weak=many), None)
    assert "but not: direction 0; direction 1; direction 2; and 6 more; " in finding.reason
    alike = tuple(WeakDirection("the offsets", one) for one in (0.4, 2.0, np.inf))
    (finding,) = check_directions(dataclasses.replace(told, weak=alike), None)
    assert "but not: the offsets; record" in finding.reason
    assert weak_lines(dataclasses.replace(told, weak=alike)) == [
        "not identified: the offsets (3 directions, uncertain by 40 and 200 % or more)"
    ]


def test_an_expected_cop_error_is_judged_by_the_width_of_the_polygon() -> None:
    assert check_expected(0.025, 0.012, {"left": 0.012}, None) == []
    (one,) = check_expected(0.025, 0.004, {"left": 0.075, "right": 0.005}, None)
    assert one.verdict == "FAIL"
    assert "75 mm (the left foot), in a sensing polygon 50 mm wide" in one.reason
    assert "right" not in one.reason
    added = DoubleSupport(0.0, -0.12, 0.4)
    (failed,) = check_expected(0.025, 0.03, {"left": 0.001}, added)
    assert failed.verdict == "FAIL"
    assert "dtheta 0.4 rad" in failed.reason
    (still,) = check_expected(0.025, 0.03, {"left": 0.001}, added, moved=0.003)
    assert "moves by no more than 3 mm in a run, as if the robot only stood" in still.reason


def test_the_worst_finding_decides_and_all_are_told_worst_first() -> None:
    warning, failure = Finding("WARN", "b"), Finding("FAIL", "a")
    assert judge([]).verdict == "PASS"
    assert judge([]).reasons
    assert judge([warning]).verdict == "WARN"
    both = judge([warning, failure])
    assert both.verdict == "FAIL"
    assert both.reasons == ("FAIL: a", "WARN: b")
    assert [split_reason(one, both.verdict) for one in (*both.reasons, "c: d")] == [
        ("FAIL", "a"), ("WARN", "b"), ("FAIL", "c: d")
    ]  # fmt: skip


def test_many_reasons_are_counted_in_one_line() -> None:
    assert list_reasons(["a", "b", "c"], 3) == "a; b; c"
    assert list_reasons(["a", "b", "c"], 1) == "a; and 2 more"


def placed(channel: str, axis: str, value: float) -> FittedDeviation:
    """Where a channel acts, as fitted [m]."""
    deviation = Deviation("cell_position", (channel,), axis, "m", 0.0015, np.zeros((1, 1)))
    return FittedDeviation(deviation, value, 0.001)


@pytest.mark.parametrize(
    ("left", "right", "words"),
    [
        (-0.022, -0.021, "of the left foot 22 mm behind and of the right foot 21 mm behind"),
        (0.012, 0.004, "of the left foot 12 mm in front"),
    ],
)
def test_soles_at_another_place_are_named_with_how_far(
    left: float, right: float, words: str
) -> None:
    shoe = shoes.shoe("nao_shoe")
    by_foot = dict(zip(FEET, (left, right), strict=True))
    found = [placed(name, "x", by_foot[name.split("/")[0]]) for name in shoe.names]
    found += [placed(name, "y", 0.004) for name in shoe.names]
    (finding,) = check_soles(shoe, found)
    assert finding.verdict == "WARN"
    assert f"the forces {words} of where the files say" in finding.reason
    assert "feet.*.sole_xyz_m" in finding.reason


def test_cells_that_are_off_each_another_way_are_no_sole() -> None:
    shoe = shoes.shoe("nao_shoe")
    assert check_soles(shoe, ()) == []
    signs = np.tile([1.0, -1.0], len(shoe.names) // 2)
    found = [placed(name, "x", 0.01 * s) for name, s in zip(shoe.names, signs, strict=True)]
    assert check_soles(shoe, found) == []


def fitted(effect: str, place: str, component: str, value: float, std: float) -> FittedDeviation:
    deviation = Deviation(effect, (place,), component, "", std, np.zeros((0, 0)))
    return FittedDeviation(deviation, value, 0.1 * std)


def test_what_the_fit_takes_the_robot_for() -> None:
    """Far from its files it is named, the worst first, each with its cure; near to them not."""
    near = [
        fitted("joint_offset", "LKneePitch", "angle", 0.015, 0.004),
        fitted("link_com", "base_link", "x", -0.011, 0.003),
        fitted("backlash", "all", "play", 0.09, 0.003),
    ]
    assert check_robot(()) == []
    assert check_robot(near) == []
    far = [
        fitted("joint_offset", "LKneePitch", "angle", 0.028, 0.004),
        fitted("link_com", "base_link", "x", -0.024, 0.003),
    ]
    (finding,) = check_robot([*near, *far])
    assert finding.verdict == "WARN"
    assert finding.reason.startswith(
        "by the fit the CoM of base_link x is off by 24 mm (8 tolerances); the zero of LKneePitch "
        "is off by 28 mrad (7 tolerances): correct CoMs in the URDF (the soles' place"
    )
    assert finding.reason.endswith(" and the zeros of the joints, then calibrate again")
    farthest = fitted("link_com", "base_link", "x", 0.055, 0.003)
    (finding,) = check_robot([*near, *far, farthest])
    assert finding.verdict == "FAIL"
    assert "the CoM of base_link x is off by 55 mm (18 tolerances)" in finding.reason
    joints = ("LHipRoll", "LKneePitch", "RHipRoll", "RKneePitch")
    many = [fitted("joint_offset", joint, "angle", 0.028, 0.004) for joint in joints]
    assert "a link of the legs" not in check_robot(many[:3])[0].reason
    assert "4 zeros at once: gears that give, or a link of the legs" in check_robot(many)[0].reason


def freed(values: dict[str, float], cost_share: float) -> FreedGears:
    """Zeros of joints [rad], with gears that are free."""
    zeros = [
        fitted("joint_offset", joint, "angle", value, 0.004) for joint, value in values.items()
    ]
    return FreedGears(tuple(zeros), {"LKneePitch": 0.012, "RKneePitch": 0.006}, cost_share)


@pytest.mark.parametrize(
    ("left", "share", "told"),
    [
        (0.028, 0.3, [("LKneePitch", "28 mrad (7 tolerances): correct the zeros of the joints")]),
        (0.021, 0.3, [("LKneePitch", "21 mrad (5 tolerances): correct the zeros of the joints")]),
        (0.015, 0.3, [("LKneePitch", "30 mrad (8 tolerances); or gears give and have play, ")]),
        (0.015, 0.3, [("LKneePitch", "turns links by 9 mrad in the mean, LKneePitch by 12: ")]),
        (0.015, 0.3, [("LKneePitch", "that leaves 30% of the misfit, so it is likelier")]),
        (0.015, 0.9, [("LKneePitch", "LKneePitch by 12: the data do not tell these apart")]),
    ],
)
def test_zeros_that_gears_explain_are_told_as_either(
    left: float, share: float, told: list[tuple[str, str]]
) -> None:
    found = fitted("joint_offset", "LKneePitch", "angle", 0.030, 0.004)
    (finding,) = check_robot([found], lambda: freed({"LKneePitch": left}, share))
    assert finding.verdict == "WARN"
    for joint, text in told:
        assert finding.reason.startswith(f"by the fit the zero of {joint} is off by ")
        assert text in finding.reason


def test_a_zero_that_stays_is_told_apart_from_those_that_gears_explain() -> None:
    values = {"LKneePitch": 0.044, "RKneePitch": 0.030}
    zeros = [fitted("joint_offset", joint, "angle", one, 0.004) for joint, one in values.items()]
    stays, either = check_robot(
        zeros, lambda: freed({"LKneePitch": 0.036, "RKneePitch": 0.005}, 0.2)
    )
    # The fit that is used is refused, whichever it is.
    assert (stays.verdict, either.verdict) == ("WARN", "FAIL")
    assert "LKneePitch is off by 36 mrad" in stays.reason
    assert "RKneePitch is off by 30 mrad" in either.reason


def test_gears_are_freed_only_where_a_zero_is_far_off() -> None:
    def never() -> FreedGears:
        raise AssertionError

    com = fitted("link_com", "base_link", "x", 0.024, 0.003)
    zero = fitted("joint_offset", "LKneePitch", "angle", 0.015, 0.004)
    assert check_robot([zero], never) == []
    assert len(check_robot([com, zero], never)) == 1
