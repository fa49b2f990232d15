"""Nodes as processes: started together, watched, and ended cleanly whatever happens."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from shoecal_core.end_with_parent import ending_with_parent
from shoecal_core.errors import ShoecalError
from shoecal_core.files import make_folder

END_S = 15.0
"""How long the nodes may take to end."""
SHOWN_LINES = 8


class NodeDiedError(ShoecalError):
    """A node that ended by itself."""


class Nodes:
    """Node processes, by name."""

    def __init__(self, logs: Path, environment: Mapping[str, str]) -> None:
        """None yet.

        Args:
            logs: folder for one log a node.
            environment: of the processes.
        """
        self._logs = logs
        self._environment = dict(environment)
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        make_folder(logs)

    def start(
        self, node: str, parameters: Mapping[str, object], files: Sequence[Path] = ()
    ) -> None:
        """Start a node; it ends with this thread, even if that is killed.

        Args:
            node: its name, and that of its module.
            parameters: go before those of the files.
            files: parameter files.
        """
        arguments = [part for file in files for part in ("--params-file", str(file))]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={_as_yaml(value)}"]
        program = [sys.executable, "-m", f"shoecal_ros.nodes.{node}"]
        with self.log(node).open("wb") as log:
            self._processes[node] = subprocess.Popen(
                ending_with_parent([*program, "--ros-args", *arguments]),
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                # An interrupt from the terminal is for the conductor, which ends the nodes.
                start_new_session=True,
            )

    def log(self, node: str) -> Path:
        """File with what a node has said."""
        return self._logs / f"{node}.log"

    def check(self) -> None:
        """See that all are running.

        Raises:
            NodeDiedError: names the one that is not, with its last lines.
        """
        for node, process in self._processes.items():
            code = process.poll()
            if code is not None:
                lines = self.log(node).read_text(errors="replace").splitlines()
                said = " | ".join(lines[-SHOWN_LINES:]) or "nothing"
                raise NodeDiedError(f"node {node} ended with code {code}; it said: {said}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # Not SIGINT: started in a shell's background, a node ignores that until it has begun.
        for process in self._processes.values():
            process.terminate()
        deadline = time.monotonic() + END_S
        for process in self._processes.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _as_yaml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | Path):
        escaped = str(value).replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return str(value)
