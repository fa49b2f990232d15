"""The main job on the simulated robot: `python -m shoecal_ros.demo --seed N --out DIR …`.

Five nodes, each its own process, talk over DDS in a domain of their own; the readings come as
bytes over a pseudo-terminal. This process starts them, asks for a self-calibration, and holds
what comes out against the simulated truth.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from shoecal_msgs.action import Calibrate

from shoecal_core.cli.progress import shown_progress
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write, read_bytes
from shoecal_core.parameter_file import load_settings
from shoecal_core.progress import Progress
from shoecal_core.recording.session import Session
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workspace import config_dir
from shoecal_ros.demonstration.conductor import Conductor
from shoecal_ros.demonstration.domain import reserve_domain
from shoecal_ros.demonstration.options import Folder, Options
from shoecal_ros.demonstration.outcome import (
    evaluate,
    print_table,
    split_truth,
    write_results,
)
from shoecal_ros.demonstration.processes import Nodes
from shoecal_ros.simulator.device_file import write_device

SPEED = 5.0
PATIENCE_S = 5.0
"""Simulated data are late on a busy machine, not stale."""
LATE_S = 4.0
"""Simulated time by which a node's clock may trail the simulator's on a busy machine."""

STAGES = {
    "drawing": "plan",
    "reaching": "record",
    "planning": "plan",
    "moving": "record",
    "solving": "solve",
    "applying": "solve",
}
"""Stage of the calibration -> where its time is counted."""
RECORDING = ("reaching", "planning", "moving")
"""Stages that come once a run."""


class Stopwatch:
    """Wall-clock time by where it went."""

    def __init__(self) -> None:
        self.spent = dict.fromkeys(("start", "plan", "record", "solve", "evaluate"), 0.0)
        self._begin = self._since = time.monotonic()

    def lap(self, place: str) -> None:
        """Count the time since the last lap."""
        now = time.monotonic()
        self.spent[place] += now - self._since
        self._since = now

    @property
    def timing(self) -> dict[str, float]:
        """Seconds by place, and in all."""
        return {**self.spent, "total": time.monotonic() - self._begin}


def run(options: Options) -> Mapping[str, object]:
    """Do it all; the figures.

    Raises:
        ShoecalError: with the cure; what was recorded stays.
    """
    watch = Stopwatch()
    folder = Folder(options.out)
    folder.prepare()
    try:
        with shown_progress() as progress:
            _calibrate(options, folder, watch, progress)
            progress("evaluating", 1.0)
    finally:
        folder.keep_session()
    session = Session.open(folder.session)
    split_truth(folder, session)
    atomic_write(folder.calibration, read_bytes(folder.state / "calibration.yaml"))
    weights = config_dir() / "nodes" / "calibrator.yaml"
    found = evaluate(
        folder,
        load_settings(CalibrationSettings, weights, "calibrator", "calibration"),
        load_settings(Tolerances, weights, "calibrator", "tolerances"),
    )
    watch.lap("evaluate")
    figures = write_results(folder, options, found, watch.timing)
    shutil.rmtree(folder.work)
    print_table(found, watch.timing, folder)
    return figures


def _calibrate(options: Options, folder: Folder, watch: Stopwatch, progress: Progress) -> None:
    """The part in which the nodes are running."""
    progress("starting the nodes", 0.0)
    default = config_dir() / "realities" / "default.yaml"
    bits = load_reality(default, options.reality).cells.converter_bits
    write_device(folder.device, load_shoe(options.shoe), folder.port, bits)
    domain, token = reserve_domain()
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    stage = "drawing"

    def receive(feedback: Calibrate.Feedback) -> None:
        nonlocal stage
        if feedback.stage != stage:
            watch.lap(STAGES[stage])
            stage = feedback.stage
        progress(step_text(feedback), feedback.progress)

    with token, Nodes(folder.logs, environment) as nodes:
        _start(nodes, options, folder)
        with Conductor(nodes, domain) as conductor:
            conductor.wait_for_nodes()
            conductor.arm()
            watch.lap("start")
            goal = Calibrate.Goal(
                supports=options.supports,
                train=options.train,
                seed=options.seed,
                target=options.target,
            )
            conductor.calibrate(goal, receive)
            conductor.see_live()
            watch.lap(STAGES[stage])


def step_text(feedback: Calibrate.Feedback) -> str:
    """The stage, with the run that is recorded in it: `moving, run 2 of 7`."""
    if feedback.stage not in RECORDING:
        return str(feedback.stage)
    return f"{feedback.stage}, run {feedback.support} of {feedback.supports}"


def _start(nodes: Nodes, options: Options, folder: Folder) -> None:
    configuration = config_dir() / "nodes"
    files = {"robot_file": options.robot.resolve(), "shoe_file": options.shoe.resolve()}
    simulated = {"use_sim_time": True}
    patient = {"stale_s": PATIENCE_S}
    planner = configuration / "planner.yaml"
    nodes.start(
        "simulator",
        {
            **files,
            "seed": options.seed,
            "speed": options.speed,
            "port": folder.port,
            "truth_file": folder.truth,
            "reality_file": options.reality.resolve() if options.reality else "",
        },
        [configuration / "simulator.yaml"],
    )
    nodes.start("shoe_driver", {**simulated, "config_file": folder.device})
    nodes.start("model", {**files, **simulated, **patient}, [configuration / "model.yaml"])
    late = {"follow_late": LATE_S}
    nodes.start("planner", {**files, **simulated, **patient, **late}, [planner])
    nodes.start(
        "calibrator",
        {
            **files,
            **simulated,
            **patient,
            "state_dir": folder.state,
            "sessions_dir": folder.sessions,
            "planner_file": planner,
            # A demo shows what it found, warnings included.
            "apply_warned": True,
        },
        [configuration / "calibrator.yaml"],
    )


def _options(argv: Sequence[str] | None) -> Options:
    config = config_dir()
    parser = argparse.ArgumentParser(description="The main job on the simulated robot.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/demo"))
    parser.add_argument("--reality", type=Path)
    parser.add_argument("--robot", type=Path, default=config / "robots" / "nao.yaml")
    parser.add_argument("--shoe", type=Path, default=config / "shoes" / "nao_shoe.yaml")
    parser.add_argument("--supports", type=int, default=5)
    parser.add_argument("--train", type=int, default=3)
    parser.add_argument("--target", type=float, default=0.0)
    parser.add_argument("--speed", type=float, default=SPEED)
    return Options(**vars(parser.parse_args(argv)))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the demo; its exit code."""
    # Whatever ends it, the nodes are ended first.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        run(_options(argv))
    except ShoecalError as error:
        Console(stderr=True, highlight=False).print(f"demo: {error}", markup=False, soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        Console(stderr=True).print("demo: interrupted; the nodes have been stopped")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
