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
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from shoecal_msgs.action import Calibrate, Diagnose, Plan, ReachSupport
from shoecal_msgs.msg import CopCorrection, DoubleSupport
from shoecal_msgs.srv import GetCalibration, SelfCalibrate, SetCalibration
from std_msgs.msg import Bool, Header

from reliability.live_robots import SUPPORT, start_calibrator
from reliability.live_world import World, live_tries
from reliability.row import Row
from reliability.tries import BrokenError
from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

NUMBERS = (math.nan, math.inf, -math.inf, 1.7e308, -1.7e308, 1e300)
LONG, TWO_LINES, ESCAPE = "x" * 1_000_000, "a\nb", "\x1b[2J"
TEXTS = ("", LONG, "left/no_such_cell", TWO_LINES, ESCAPE, "../../etc/passwd", "/")
LONGEST_REASON = 3000
COUNT = 8
TIMEOUT_S = 60.0
BAD, ELSEWHERE = SetCalibration.Response.BAD_CALIBRATION, SetCalibration.Response.NOT_APPLICABLE


def _correction(field: str, number: float) -> list[CopCorrection]:
    made = CopCorrection(foot="left", active=True, m=[0.0] * 4, n=[0.0] * 4)
    made.force_min, made.force_max = [0.0] * 4, [1.0] * 4
    getattr(made, field)[0] = number
    return [made]


SUMS = ("a", "b", "m", "n", "cop_min", "force_min")
CALIBRATIONS: tuple[tuple[str, tuple[Any, ...], int], ...] = (
    ("gain", NUMBERS, BAD),
    ("offset", NUMBERS, BAD),
    ("covariance", NUMBERS, BAD),
    ("gain", tuple([1.0] * count for count in (0, COUNT - 1, COUNT + 1, 100_000)), BAD),
    ("offset", tuple([1.0] * count for count in (0, COUNT - 1, COUNT + 1, 100_000)), BAD),
    ("covariance", tuple([1.0] * count for count in range(1, COUNT + 1)), BAD),
    ("column_covariance", tuple([1.0] * count for count in range(1, COUNT + 1)), BAD),
    ("support_covariance", tuple([1.0] * count for count in range(1, COUNT + 1)), BAD),
    ("weight", (*NUMBERS, 0.0, -50.0), BAD),
    ("time_offset", NUMBERS, BAD),
    ("temperature", NUMBERS[1:], BAD),
    ("correction", tuple(_correction(*one) for one in product(SUMS, NUMBERS)), BAD),
    ("correction", tuple(_correction(f"{one}_max", -math.inf) for one in ("cop", "force")), BAD),
    ("channel", TEXTS[:3], ELSEWHERE),
    ("channel", ([],), BAD),
    ("id", ("", LONG, TWO_LINES, ESCAPE), BAD),
    ("source", ("", LONG, TWO_LINES, ESCAPE), BAD),
    ("reasons", (["x"] * 100_000, [ESCAPE]), BAD),
    ("fitted_runs", ([LONG],), BAD),
    ("verdict", ("", "pass", LONG), BAD),
    ("verdict", ("FAIL",), ELSEWHERE),
    ("format", (0, 2, 2**32 - 1), BAD),
    ("header", (Header(stamp=Time(sec=-(2**31))),), BAD),
)
"""Field of a calibration, its bad values, and the code; a number or text goes into a list's drawn
place."""

SUPPORTS = (
    {"supports": 2**32 - 1},
    {"supports": 2**32 - 1, "train": 2**32 - 1},
    {"supports": 3, "train": 4},
    {"supports": 1, "train": 1},
    {"train": 1},
    {"supports": 101, "train": 3},
)
SELF_CALIBRATIONS = tuple(
    {**supports, "seed": seed} for supports in SUPPORTS for seed in (-1, 0, 2**63 - 1, -(2**63))
)
DIAGNOSES: tuple[dict[str, Any], ...] = (
    *({"session": text} for text in (*TEXTS[1:], "..")),
    {"session": "nowhere", "run_proposed": True},
    *({"motions": ["landmarks", text]} for text in TEXTS),
    {"motions": ["landmarks"] * 100_000},
)
PLANS: tuple[dict[str, Any], ...] = (
    *({"motion": text, "send": True} for text in TEXTS),
    {"motion": "landmarks", "stream": True},
    {"motion": "unload_left", "send": True, "stream": True},
)
REACHES = tuple(
    {"support": DoubleSupport(**{"dy": -0.11, field: number})}
    for field in ("dx", "dy", "dtheta")
    for number in NUMBERS
)
PARAMETERS = tuple(
    {"parameters": [Parameter(name, value=value).to_parameter_msg()]}
    for name, value in (
        ("in_force.gains", [math.nan] * COUNT),
        ("use_sim_time", True),
        ("state_dir", "/"),
        ("sessions_dir", "/"),
        ("in_force.id", "mine"),
        ("robot_file", "/etc/passwd"),
        ("stale_s", math.inf),
    )
)
UNREACHABLE = ReachSupport.Result.UNREACHABLE
REQUESTS: tuple[tuple[Any, str, tuple[dict[str, Any], ...], int | None], ...] = (
    (SelfCalibrate, "shoe/self_calibrate", SELF_CALIBRATIONS, Calibrate.Result.BAD_GOAL),
    (Calibrate, "shoe/calibrate", SELF_CALIBRATIONS, Calibrate.Result.BAD_GOAL),
    (Diagnose, "shoe/diagnose", DIAGNOSES, Diagnose.Result.BAD_GOAL),
    (Plan, "shoe/plan", PLANS, Plan.Result.BAD_GOAL),
    (ReachSupport, "robot/reach_support", REACHES, UNREACHABLE),
    (ReachSupport, "sim/robot/reach_support", REACHES, UNREACHABLE),
    (SetParameters, "calibrator/set_parameters", PARAMETERS, None),
)
"""Service or action, its name, the fields of bad requests, and the code that the answer must have;
None where it has no room for one."""


@dataclass(frozen=True)
class Request:
    """One that must be refused with a code; `what` it is in a few words."""

    kind: Any
    name: str
    fields: dict[str, Any]
    code: int | None
    what: str


def draw(number: int, rng: np.random.Generator) -> Request:
    """A request to every service and action in turn, with four calibrations first."""
    turn = number % (len(REQUESTS) + 4) - 4
    if turn >= 0:
        kind, name, choices, code = REQUESTS[turn]
        fields = choices[rng.integers(len(choices))]
        return Request(kind, name, fields, code, f"{name} {str(fields)[:60]}")
    made = calibration_to_ros(
        calibration(nao(), nao_shoe(), identity="bad", covariance=np.eye(2 * COUNT))
    )
    field, values, code = CALIBRATIONS[rng.integers(len(CALIBRATIONS))]
    value = values[rng.integers(len(values))]
    if hasattr(getattr(made, field), "append") and not isinstance(value, list):
        getattr(made, field)[rng.integers(COUNT)] = value
    else:
        setattr(made, field, value)
    fields = {"calibration": made, "force": bool(rng.integers(2))}
    what = f"calibration with {field} {str(value)[:60]}"
    return Request(SetCalibration, "shoe/set_calibration", fields, code, what)


class Scene:
    """The nodes that offer services and actions."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = StandingRobot(world, SUPPORT)
        world.start("planner", {"steps": True, "stale_s": 5.0})
        port = world.folder / "port"
        world.start("simulator", {"port": port, "needs_arming": False}, "-r", "__ns:=/sim")
        world.node.create_publisher(Bool, "shoe/armed", qos.LATCHED).publish(Bool(data=True))
        start_calibrator(world)
        self.before = self._in_force()
        world.until_reported("planner", "planning", "ready")
        world.until_reported("calibrator", "voltages", "come")

    def attempt(self, number: int, rng: np.random.Generator) -> None:
        """Send a request that must be refused."""
        request = draw(number, rng)
        accepted, code, reason = self._answer(request)
        if accepted or code != request.code:
            outcome = "was accepted" if accepted else f"was refused with the code {code}"
            raise BrokenError(f"{request.what} {outcome}: {reason[:100]}")
        if not reason or "\n" in reason or len(reason) > LONGEST_REASON:
            raise BrokenError(f"{request.what}: a reason of {len(reason)} letters")
        if self._in_force() != self.before:
            raise BrokenError(f"{request.what} changed the calibration in force")
        for node in self.world.processes:
            if "Traceback" in self.world.output(node):
                raise BrokenError(f"{request.what}: a traceback in the log of {node}")

    def _answer(self, request: Request) -> tuple[bool, int | None, str]:
        """Whether a request was accepted, the code of its refusal and the reason."""
        kind, name, fields = request.kind, request.name, request.fields
        if hasattr(kind, "Goal"):
            result = self.world.goal(kind, name, kind.Goal(**fields)).result(TIMEOUT_S)
            return result.success or result.error_code == 0, result.error_code, result.message
        response = self.world.call(kind, name, kind.Request(**fields))
        if kind is SetParameters:
            (result,) = response.results
            return result.successful, None, result.reason
        accepted = response.accepted if kind is SelfCalibrate else response.success
        return accepted, response.error_code, response.message

    def _in_force(self) -> str:
        # As text: a temperature that is NaN differs from itself.
        return repr(
            self.world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
        )


ROW = Row(
    key="wrong-input",
    fault="wrong service input: NaN, infinite, huge, empty, unknown cell",
    holds="refused with the reason and its code; the calibration in force stays",
    tries=2000,
    step=500,
    run=partial(live_tries, Scene, worst="refused, every one of them, with its code"),
)
