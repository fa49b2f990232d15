"""CoM and soles of many samples, beside a Python loop over Pinocchio.

    .venv/bin/python benchmarks/kinematics.py [--samples 100000] [--repetitions 15]

Both compute the same quantities from the same angles in the same process, in turns: the CoM in both
soles' frames, the right sole in the left one and the left sole in the base.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import fields

import casadi as ca
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import bench_json
import pages
from shoecal_core.batch import LEAST
from shoecal_core.compiled import compiler_state
from shoecal_core.compiler import SWITCH
from shoecal_core.model.kinematics import BodyStates, Kinematics
from shoecal_core.model.robot import Robot
from shoecal_core.model.robot_file import load_robot
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.workspace import config_dir

FloatArray = NDArray[np.float64]
COMMAND = "make kinematics"
FASTER, LARGEST_ERROR = 60.0, 1e-12
"""Targets; the error in m or entries of rotations."""
OFTEN = 5
"""Calls a turn of what takes so little that another process's turn counts."""
FREE_BASE = 7
"""Numbers of Pinocchio's configuration before the joints: the base's place and quaternion."""


def pinocchio_loop(robot: Robot, angles: FloatArray) -> BodyStates:
    """The same as a user of Pinocchio would write it."""
    model, data = robot.model, robot.model.createData()
    left_frame, right_frame = (foot.frame for foot in robot.feet)
    count = len(angles)
    states = BodyStates(
        np.empty((count, 2, 3)), np.empty((count, 3, 3)), np.empty((count, 3)),
        np.empty((count, 3, 3)), np.empty((count, 3)),
    )  # fmt: skip
    configuration = pin.neutral(model)
    for index in range(count):
        configuration[FREE_BASE:] = angles[index]
        com = pin.centerOfMass(model, data, configuration, False)
        left = pin.updateFramePlacement(model, data, left_frame)
        right = pin.updateFramePlacement(model, data, right_frame)
        relative = left.actInv(right)
        states.com[index, 0] = left.actInv(com)
        states.com[index, 1] = right.actInv(com)
        states.rotation[index] = relative.rotation
        states.translation[index] = relative.translation
        states.left_rotation[index] = left.rotation
        states.left_translation[index] = left.translation
    return states


def largest_difference(one: BodyStates, other: BodyStates) -> float:
    """Of all quantities [m or entries]."""
    return max(
        float(np.abs(getattr(one, field.name) - getattr(other, field.name)).max())
        for field in fields(BodyStates)
    )


def milliseconds_of(function: Callable[[], object]) -> tuple[float, float]:
    """By the clock, and of the processor."""
    clock, processor = time.perf_counter(), time.process_time()
    function()
    return 1e3 * (time.perf_counter() - clock), 1e3 * (time.process_time() - processor)


def first_call(robot: Robot, angles: FloatArray) -> float:
    """Time [ms] that a process's first long call takes; what it evaluates takes next to none."""
    kinematics = Kinematics(robot)
    return milliseconds_of(lambda: kinematics.states(angles[:LEAST]))[0]


def interpreted_of(robot: Robot, angles: FloatArray) -> Kinematics:
    """Kinematics that stay interpreted."""
    kinematics = Kinematics(robot)
    os.environ[SWITCH] = "0"
    kinematics.states(angles[:LEAST])
    del os.environ[SWITCH]
    return kinematics


def measure(robot: Robot, angles: FloatArray, repetitions: int) -> dict[str, float]:
    """All figures."""
    figures = {
        "samples": float(len(angles)),
        "first_call_ms": first_call(robot, angles),
        "cached_call_ms": first_call(robot, angles),
    }
    compiled, interpreted = Kinematics(robot), interpreted_of(robot, angles)
    ways: dict[str, Callable[[], BodyStates]] = {
        "compiled": lambda: compiled.states(angles),
        "interpreted": lambda: interpreted.states(angles),
        "pinocchio_loop": lambda: pinocchio_loop(robot, angles),
    }
    true = ways["pinocchio_loop"]()
    figures["max_error"] = largest_difference(ways["compiled"](), true)
    figures["max_error_interpreted"] = largest_difference(ways["interpreted"](), true)
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for turn in range(repetitions):
        for name, way in ways.items():
            times[name] += [milliseconds_of(way) for _ in range(OFTEN if name == "compiled" else 1)]
        told = ", ".join(f"{name} {spent[-1][0]:.1f} ms" for name, spent in times.items())
        print(f"{turn + 1} of {repetitions}: {told}", flush=True)
    for name, spent in times.items():
        clock, processor = np.transpose(spent)
        figures[f"{name}_ms"] = float(np.median(clock))
        figures[f"{name}_p95_ms"] = float(np.percentile(clock, 95))
        figures[f"{name}_cpu_ms"] = float(np.median(processor))
    for name in ("pinocchio_loop", "interpreted"):
        figures[f"vs_{name}"] = figures[f"{name}_ms"] / figures["compiled_ms"]
        figures[f"vs_{name}_cpu"] = figures[f"{name}_cpu_ms"] / figures["compiled_cpu_ms"]
    return figures


BODY = """\
## CoM and soles of {samples:.0f} samples

Made by `{command}`.

NAO with random joint angles; CoM in both sole frames, right sole in the left, left sole in the
base. {repetitions} alternating repetitions (compiled: {often} each), one process, one thread.

{table}

Compiled is **{vs_pinocchio_loop:.0f} times** faster than the loop by the clock
({vs_pinocchio_loop_cpu:.0f} times in processor time) and {vs_interpreted:.0f} times faster than
interpreted. *Difference*: largest deviation from the loop. Calls with fewer than {least} samples
are interpreted. The first longer call compiles and verifies the function: {first_call_ms:.0f} ms;
in later processes {cached_call_ms:.0f} ms from the cache. Sines and cosines are vectorised (eight
samples with AVX-512).

Measured on {cores} cores ({machine}), OPENBLAS_NUM_THREADS {threads}, with {compiler}, Python
{python}, numpy {numpy}, casadi {casadi}, pinocchio {pinocchio}.
"""


def body(figures: dict[str, float], repetitions: int) -> str:
    """The section of docs/evidence/performance.md."""
    rows = [
        [
            label,
            f"{figures[f'{name}_ms']:.1f}",
            f"{figures[f'{name}_p95_ms']:.1f}",
            f"{figures[f'{name}_cpu_ms']:.1f}",
            error,
        ]
        for label, name, error in (
            ("compiled", "compiled", f"{figures['max_error']:.1e}"),
            ("interpreted by CasADi", "interpreted", f"{figures['max_error_interpreted']:.1e}"),
            ("Python loop over Pinocchio", "pinocchio_loop", "-"),
        )
    ]
    head = ["", "median [ms]", "95 % [ms]", "processor, median [ms]", "difference [m or entry]"]
    return BODY.format(
        **figures,
        table=pages.table([head, *rows]),
        command=COMMAND,
        repetitions=repetitions,
        often=OFTEN,
        least=LEAST,
        cores=os.cpu_count(),
        machine=platform.machine(),
        threads=os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        compiler=compiler_state().get("compiler", "no compiler"),
        python=platform.python_version(),
        numpy=np.__version__,
        casadi=ca.CasadiMeta.version(),
        pinocchio=pin.__version__,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--repetitions", type=int, default=15)
    args = parser.parse_args(arguments)
    config = config_dir()
    robot = load_robot(
        config / "robots" / "nao.yaml", load_shoe(config / "shoes" / "nao_shoe.yaml")
    )
    angles = np.random.default_rng(0).uniform(
        robot.lower, robot.upper, (args.samples, len(robot.joint_names))
    )
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache  # the first call is to compile
        figures = measure(robot, angles, args.repetitions)
    bench_json.record("kinematics", figures)
    pages.write_performance("kinematics", body(figures, args.repetitions))
    print(json.dumps(figures, indent=1))
    met = {
        f"at least {FASTER:g} times faster": figures["vs_pinocchio_loop"] >= FASTER,
        f"at most {LARGEST_ERROR:g} off": figures["max_error"] <= LARGEST_ERROR,
    }
    for target in (target for target, reached in met.items() if not reached):
        print(f"missed: {target}")
    return 0 if all(met.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
