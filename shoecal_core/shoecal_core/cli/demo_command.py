"""`shoecal demo`: the main job on the simulated robot, over real ROS 2 nodes.

The nodes are processes of another package; this command starts that package's demo in an
environment that has ROS 2.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import cast

from rich.console import Console

from shoecal_core.cli.arguments import add_shoe, length_mm, seed_number, shoe_file
from shoecal_core.cli.prose import say
from shoecal_core.end_with_parent import ending_with_parent
from shoecal_core.errors import ShoecalError, ToldError
from shoecal_core.files import read_bytes
from shoecal_core.workspace import config_dir, ros_environment


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("--seed", type=seed_number, default=1, help="draws robot, cells, supports")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", default=Path("out/demo"), help="folder of the results"
    )
    parser.add_argument(
        "--reality", type=Path, metavar="FILE", help="changes to the default simulated reality"
    )
    parser.add_argument("--robot", type=Path, metavar="FILE", help="robot file (default: the NAO)")
    add_shoe(parser)
    parser.add_argument("--supports", type=int, default=5, help="double supports to visit")
    parser.add_argument("--train", type=int, default=3, help="of them used for the fit")
    parser.add_argument(
        "--target", type=length_mm, metavar="MM",
        help="expected CoP error of each foot (mm) at which no further run trains (default: all "
        "runs train)",
    )  # fmt: skip


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Run the demo in a ROS environment and hand on what it found."""
    if not 2 <= args.train <= args.supports:
        raise ShoecalError(
            f"--train {args.train}, --supports {args.supports}: at least 2 must train, and at "
            "most all"
        )
    config = config_dir()
    robot = args.robot or config / "robots" / "nao.yaml"
    shoe = shoe_file(args, robot)
    say(console, f"{robot} with {shoe}")
    command = [
        sys.executable, "-m", "shoecal_ros.demo",
        "--seed", str(args.seed),
        "--out", str(args.out),
        "--robot", str(robot),
        "--shoe", str(shoe),
        "--supports", str(args.supports),
        "--train", str(args.train),
    ]  # fmt: skip
    if args.target is not None:
        command += ["--target", str(1e-3 * args.target)]
    if args.reality is not None:
        command += ["--reality", str(args.reality)]
    environment = ros_environment()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends the demo as Ctrl-C does
    process = subprocess.Popen(ending_with_parent(command), env=environment)
    try:
        code = process.wait()
    except KeyboardInterrupt:
        # It stops its nodes itself. From a terminal it got the same interrupt; twice does no harm.
        process.terminate()
        process.wait()
        raise
    if code != 0:
        raise ToldError
    say(console, f"{args.out / 'report.html'}")
    return cast(Mapping[str, object], json.loads(read_bytes(args.out / "result.json")))
