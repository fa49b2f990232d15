"""Requests that make no sense, to every service and action of the suite.

A real calibrator with a calibration in force, a real planner (with its own steps) and a real
simulator get requests whose fields are drawn: NaN, infinite, huge, empty, of the wrong length,
cells and motions that there are not, texts of a megabyte, paths where a name belongs. Each must be
refused within the time-out with a reason of one line and the code that says whose fault it is, the
caller's; the calibration in force stay as it was to the last bit, and no node end or log a
traceback. Nothing is simulated but the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from shoecal_msgs.action import Calibrate, Diagnose, Plan, ReachSupport
from shoecal_msgs.msg import CopCorrection, DoubleSupport
from shoecal_msgs.srv import GetCalibration, SelfCalibrate, SetCalibration
from std_msgs.msg import Bool

from reliability.live_world import COMPILE_S, World, live_world
from reliability.row import Progress, Result, Row
from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from shoecal_core.model.double_support import DoubleSupport as Support
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

NUMBERS = (math.nan, math.inf, -math.inf, 1.7e308, -1.7e308, 1e300)
TEXTS = ("", "x" * 1_000_000, "left/no_such_cell", "a\nb", "\x1b[2J", "../../etc/passwd", "/")
LONGEST_REASON = 3000
COUNT = 8
TIMEOUT_S = 60.0


@dataclass(frozen=True)
class Case:
    """A request that must be refused.

    Attributes:
        what: in words.
        kind, name: of service or action.
        request: to send.
        codes: one of them tells a program why; none where the answer has no room for it.
    """

    what: str
    kind: Any
    name: str
    request: Any
    codes: frozenset[int]


Draw = Callable[[np.random.Generator], Case]


def _pick(rng: np.random.Generator, choices: Any) -> Any:
    return choices[int(rng.integers(len(choices)))]


def _set_calibration(rng: np.random.Generator) -> Case:
    """A calibration with one field spoilt."""
    made = calibration_to_ros(
        calibration(nao(), nao_shoe(), identity="bad", covariance=np.eye(2 * COUNT))
    )
    number, place = _pick(rng, NUMBERS), int(rng.integers(COUNT))

    def one(name: str) -> None:
        values = getattr(made, name)
        values[place] = number

    def length(name: str) -> None:
        wrong = (0, COUNT - 1, COUNT + 1, 100_000)
        setattr(made, name, np.ones(_pick(rng, wrong)).tolist())

    def correction() -> None:
        term = CopCorrection(foot="left", active=True, m=[0.0] * 4, n=[0.0] * 4)
        term.force_min, term.force_max = [0.0] * 4, [1.0] * 4
        field = _pick(rng, ("a", "b", "m", "n", "cop_min", "cop_max", "force_min", "force_max"))
        getattr(term, field)[0] = -math.inf if field.endswith("max") else number
        made.correction = [term]

    def cells() -> None:
        made.channel = [*made.channel[:place], _pick(rng, TEXTS[:3]), *made.channel[place + 1 :]]

    spoil: dict[str, Callable[[], None]] = {
        "gain": lambda: one("gain"),
        "offset": lambda: one("offset"),
        "covariance": lambda: one("covariance"),
        "gain's length": lambda: length("gain"),
        "offset's length": lambda: length("offset"),
        "covariance's length": lambda: setattr(made, "covariance", [1.0] * (place + 1)),
        "weight": lambda: setattr(made, "weight", _pick(rng, (*NUMBERS, 0.0, -50.0))),
        "time_offset": lambda: setattr(made, "time_offset", number),
        "temperature": lambda: setattr(made, "temperature", _pick(rng, NUMBERS[1:])),
        "correction": correction,
        "cell": cells,
        "no cells": lambda: setattr(made, "channel", []),
        "id": lambda: setattr(made, "id", _pick(rng, (*TEXTS[:2], *TEXTS[3:5]))),
        "source": lambda: setattr(made, "source", _pick(rng, (*TEXTS[:2], *TEXTS[3:5]))),
        "reasons": lambda: setattr(made, "reasons", _pick(rng, (["x"] * 100_000, [TEXTS[4]]))),
        "fitted_runs": lambda: setattr(made, "fitted_runs", [TEXTS[1]]),
        "verdict": lambda: setattr(made, "verdict", _pick(rng, ("", "FAIL", "pass", TEXTS[1]))),
        "format": lambda: setattr(made, "format", _pick(rng, (0, 2, 2**32 - 1))),
        "stamp": lambda: setattr(made.header.stamp, "sec", -(2**31)),
    }
    field = _pick(rng, list(spoil))
    spoil[field]()
    request = SetCalibration.Request(calibration=made, force=bool(rng.integers(2)))
    # Whole, but of other cells, or one whose own checks failed.
    elsewhere = field == "cell" or made.verdict == "FAIL"
    answers = SetCalibration.Response
    code = answers.NOT_APPLICABLE if elsewhere else answers.BAD_CALIBRATION
    what = f"set_calibration: {field}"
    return Case(what, SetCalibration, "shoe/set_calibration", request, frozenset({code}))


_TOO_MANY = (
    {"supports": 2**32 - 1},
    {"supports": 2**32 - 1, "train": 2**32 - 1},
    {"supports": 3, "train": 4},
    {"supports": 1, "train": 1},
    {"train": 1},
    {"supports": 101, "train": 3},
)


def _self_calibrate(rng: np.random.Generator) -> Case:
    goal = {**_pick(rng, _TOO_MANY), "seed": int(_pick(rng, (-1, 0, 2**63 - 1, -(2**63))))}
    codes = frozenset({Calibrate.Result.BAD_GOAL})
    if rng.integers(2):
        request = SelfCalibrate.Request(**goal)
        return Case(f"self_calibrate: {goal}", SelfCalibrate, "shoe/self_calibrate", request, codes)
    return Case(f"calibrate: {goal}", Calibrate, "shoe/calibrate", Calibrate.Goal(**goal), codes)


def _diagnose(rng: np.random.Generator) -> Case:
    goal = _pick(
        rng,
        (
            *({"session": text} for text in TEXTS[1:]),
            {"session": "/"},
            {"session": ".."},
            {"session": "nowhere", "run_proposed": True},
            *({"motions": ["landmarks", text]} for text in TEXTS),
            {"motions": ["landmarks"] * 100_000},
        ),
    )
    codes = frozenset({Diagnose.Result.BAD_GOAL})
    what = f"diagnose: {str(goal)[:60]}"
    return Case(what, Diagnose, "shoe/diagnose", Diagnose.Goal(**goal), codes)


def _plan(rng: np.random.Generator) -> Case:
    goal = _pick(
        rng,
        (
            *({"motion": text, "send": True} for text in TEXTS),
            {"motion": "landmarks", "stream": True},
            {"motion": "unload_left", "send": True, "stream": True},
        ),
    )
    codes = frozenset({Plan.Result.BAD_GOAL})
    return Case(f"plan: {str(goal)[:60]}", Plan, "shoe/plan", Plan.Goal(**goal), codes)


_REACHES = ("robot/reach_support", "sim/robot/reach_support")
"""Who brings the feet to a support."""


def _reach(rng: np.random.Generator) -> Case:
    place = [0.0, -0.11, 0.0]
    place[int(rng.integers(3))] = _pick(rng, NUMBERS)
    goal = ReachSupport.Goal(support=DoubleSupport(dx=place[0], dy=place[1], dtheta=place[2]))
    name = _pick(rng, _REACHES)
    codes = frozenset({ReachSupport.Result.UNREACHABLE})
    return Case(f"{name}: {place}", ReachSupport, name, goal, codes)


def _parameter(rng: np.random.Generator) -> Case:
    name, value = _pick(
        rng,
        (
            ("in_force.gains", [math.nan] * COUNT),
            ("use_sim_time", True),
            ("state_dir", "/"),
            ("sessions_dir", "/"),
            ("in_force.id", "mine"),
            ("robot_file", "/etc/passwd"),
            ("stale_s", math.inf),
        ),
    )
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    what = f"parameter {name}"
    return Case(what, SetParameters, "calibrator/set_parameters", request, frozenset())


DRAWS: tuple[Draw, ...] = (
    *(_set_calibration,) * 4, _self_calibrate, _diagnose, _plan, _reach, _parameter
)  # fmt: skip


class Suite:
    """The nodes, and clients of all they offer."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = StandingRobot(world, Support(0.0, -0.112, 0.0))
        folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
        world.start("calibrator", folders)
        world.start("planner", {"steps": True, "stale_s": 5.0})
        port = world.folder / "port"
        world.start("simulator", {"port": port, "needs_arming": False}, "-r", "__ns:=/sim")
        world.node.create_publisher(Bool, "shoe/armed", qos.LATCHED).publish(Bool(data=True))
        made = calibration_to_ros(calibration(nao(), nao_shoe()))
        request = SetCalibration.Request(calibration=made)
        assert world.call(SetCalibration, "shoe/set_calibration", request).success
        self.before = self._in_force()
        world.until_reported("planner", "planning", "ready", COMPILE_S)
        world.until_reported("calibrator", "voltages", "come")

    def try_one(self, case: Case) -> str:
        """What is wrong with how a case was answered; empty where nothing is."""
        is_action = hasattr(case.kind, "Goal")
        ok, code, told = (self._goal if is_action else self._call)(case)
        if ok:
            return f"accepted: {told[:100]}"
        if code not in (case.codes or {None}):
            return f"refused with the code {code}: {told[:100]}"
        if not told or "\n" in told or len(told) > LONGEST_REASON:
            return f"a reason of {len(told)} letters"
        if self._in_force() != self.before:
            return "the calibration in force changed"
        return ""

    def _call(self, case: Case) -> tuple[bool, int | None, str]:
        """Whether it was accepted, the code of the refusal and its reason."""
        response = self.world.call(case.kind, case.name, case.request)
        if case.kind is SetParameters:
            return bool(response.results[0].successful), None, str(response.results[0].reason)
        ok = response.accepted if case.kind is SelfCalibrate else response.success
        return bool(ok), int(response.error_code), str(response.message)

    def _goal(self, case: Case) -> tuple[bool, int | None, str]:
        """Likewise."""
        result = self.world.goal(case.kind, case.name, case.request).result(TIMEOUT_S)
        code = int(result.error_code)
        return bool(result.success or code == 0), code, str(result.message)

    def _in_force(self) -> tuple[bytes, Any]:
        found = self.world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
        # Bytes: a temperature that nobody knows differs from itself.
        return serialize_message(found.calibration), found.since

    def logs(self) -> str:
        """What was logged that should not be."""
        outputs = (self.world.output(name) for name in self.world.processes)
        return "a traceback in the log" if any("Traceback" in one for one in outputs) else ""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Tries first to first + count - 1."""
    failures: list[str] = []
    with live_world() as world:
        suite = Suite(world)
        for done, index in enumerate(range(first, first + count), start=1):
            rng = np.random.default_rng([seed, index])
            case = DRAWS[index % len(DRAWS)](rng)
            if wrong := suite.try_one(case):
                failures.append(f"{case.what}: {wrong}")
            progress(done)
        if wrong := suite.logs():
            failures.append(wrong)
    worst = "; ".join(failures) if failures else "refused, every one of them, with its code"
    return Result(count, len(failures), worst, float(len(failures)))


ROW = Row(
    key="wrong-input",
    fault="wrong service input: NaN, infinite, huge, empty, unknown cell",
    holds="refused with the reason and its code; the calibration in force stays",
    tries=2000,
    step=500,
    run=run,
)
