"""Both chains as processes, and what they are driven with."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from live import bodies
from live.line import Line
from shoecal_core.arrays import IntArray
from shoecal_core.end_with_parent import ending_with_parent
from shoecal_core.estimation.calibration import save_calibration
from shoecal_core.workspace import ros_environment
from shoecal_ros.demonstration.domain import reserve_domain
from shoecal_ros.serial.config import load_driver_config
from shoecal_ros.simulator.device_file import write_device

BITS = 24
END_S = 20.0
CHAINS = ("shoecal", "bare")


class Chains:
    """The driver and the calibrator, the bare nodes, the listener, the standing robot.

    Attributes:
        lines: the serial line of each chain.
        of_numbers: (NUMBERS,) CoP of numbered frames [m].
    """

    def __init__(self, folder: Path) -> None:
        """Start them; they are ended at the end of the context."""
        self._folder = folder
        self._domain, self._token = reserve_domain()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        device = folder / "device.yaml"
        ports = {name: folder / f"{name}_port" for name in CHAINS}
        write_device(device, bodies.shoe(), ports["shoecal"], BITS)
        volts = load_driver_config(device).channels[0].converter.volts_per_count
        counts = bodies.numbered_counts(volts)
        self.of_numbers = bodies.cop_of(counts, volts)
        self.lines = {name: Line(port, counts) for name, port in ports.items()}
        state = folder / "state"
        state.mkdir()
        save_calibration(bodies.calibration(), state / "calibration.yaml")
        self._heard = folder / "heard.npz"
        self.start("listener", "-m", "live.listener", str(self._heard))
        self.start("robot", "-m", "live.robot")
        self.start("bare_first", "-m", "live.relay", "first", str(ports["bare"]))
        self.start("bare_second", "-m", "live.relay", "second")
        self.start_node("shoe_driver", {"config_file": device})
        self.start_node("calibrator", {"state_dir": state, "sessions_dir": folder / "sessions"})

    def start_node(self, node: str, parameters: Mapping[str, object]) -> None:
        """Start one of shoecal's nodes."""
        pairs = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
        self.start(node, "-m", f"shoecal_ros.nodes.{node}", "--ros-args", *pairs)

    def start(self, name: str, *arguments: str) -> None:
        """Start a process of Python, which ends with this one even where that is killed."""
        environment = ros_environment() | {
            "ROS_DOMAIN_ID": str(self._domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "OPENBLAS_NUM_THREADS": "1",
        }
        paths = [str(Path(__file__).parents[1]), environment.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
        with self.log(name).open("w") as log:
            self._processes[name] = subprocess.Popen(
                ending_with_parent([sys.executable, *arguments]), env=environment,
                stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            )  # fmt: skip

    def log(self, name: str) -> Path:
        """What a process has said."""
        return self._folder / f"{name}.log"

    def stop(self, name: str) -> None:
        """End a process, as Ctrl-C does."""
        process = self._processes.pop(name)
        process.send_signal(signal.SIGINT)
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def heard(self) -> dict[str, tuple[IntArray, IntArray]]:
        """End the listener; of each chain the times [ns] and the numbers of what it heard."""
        self.stop("listener")
        found = np.load(self._heard)
        heard = {}
        for name in CHAINS:
            at_ns, x = found[name].T
            numbers = bodies.numbers_of(x, self.of_numbers) if name == "shoecal" else x
            heard[name] = at_ns.astype(np.int64), numbers.astype(np.int64) % bodies.NUMBERS
        return heard

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for name in list(self._processes):
            self.stop(name)
        for line in self.lines.values():
            line.close()
        self._token.close()
