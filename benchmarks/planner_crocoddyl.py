"""crocoddyl beside our solvers: in a virtual environment of its own, in a process of its own."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from pages import ROOT
from planner_cases import Span
from shoecal_core.compiler import library
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.problem import FOOT_ROWS, TASKS, HorizonProblem, Solution

FloatArray = NDArray[np.float64]
VENV = ROOT / "out" / "crocoddyl-venv"
PINNED = ("crocoddyl==3.2.1", "pin==4.1.0", "eigenpy==3.13.0", "casadi==3.8.2", "numpy==2.4.6")
SOLVER = "SolverBoxDDP"
"""Its box takes the bounds of the transitions; SolverBoxFDDP stops early on some horizons."""
PENALTY, TORQUE_PENALTY = 3e3, 3e2
"""Factors on violations [1/m, 1/rad; 1/(N m)] whose squares are added to the cost.

Three times smaller ones leave half a millimetre, three times larger ones take far longer.
"""


class UnavailableError(Exception):
    """It cannot be installed here, and why."""


def python_with_crocoddyl(venv: Path = VENV) -> Path:
    """The interpreter of an environment that has it, made where there is none.

    Raises:
        UnavailableError: when it cannot be installed.
    """
    python, complete = venv / "bin" / "python", venv / ".complete"
    wanted = "\n".join(PINNED)
    if complete.is_file() and complete.read_text() == wanted:
        return python
    print(f"installing {PINNED[0]} into {venv}, once", flush=True)
    install = [str(python), "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    for command in ([sys.executable, "-m", "venv", "--clear", str(venv)], [*install, *PINNED]):
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            raise UnavailableError((done.stderr.strip().splitlines() or ["no reason given"])[-1])
    complete.write_text(wanted)
    return python


class Crocoddyl:
    """A process that solves horizons of one robot; as a context, it ends with it.

    Raises:
        UnavailableError: when it does not start.
    """

    def __init__(self, collocation: Collocation, python: Path, **setup: object) -> None:
        self._collocation = collocation
        self._edges = collocation.edges
        name, shared, rows = _stage(collocation)
        told = {
            "name": name, "library": shared, "rows": rows, "tasks": TASKS,
            "foot_rows": FOOT_ROWS, "count": collocation.settings.horizon,
            "size": len(collocation.lower), "solver": SOLVER, "penalty": PENALTY,
            "torque_penalty": TORQUE_PENALTY,
            "transition_weight": collocation.settings.transition_weight,
        }  # fmt: skip
        worker = Path(__file__).with_name("planner_crocoddyl_worker.py")
        self._process = subprocess.Popen(
            [str(python), str(worker)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._send(told | setup)
        self._receive()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate()

    def run(self, problem: HorizonProblem, guess: FloatArray) -> tuple[Solution, Span]:
        """See Racer. The time is the worker's own, without that of talking to it."""
        problem = dataclasses.replace(problem, scene=problem.scene.padded(self._edges))
        scene, limits = problem.scene, self._collocation.limits(problem)
        shape = (len(guess),)
        each: dict[str, FloatArray] = {
            "foot_poses": scene.foot_poses, "shares": scene.shares, "normals": scene.normals,
            "offsets": limits.offsets, "targets": problem.aim.targets,
            "clearances": limits.clearances, "lower": limits.lower, "upper": limits.upper,
        }  # fmt: skip
        all_states = {
            key: np.broadcast_to(rows, (*shape, *rows.shape[1:])) for key, rows in each.items()
        }
        once = {
            "start": problem.start, "previous": problem.previous, "guess": guess,
            "others": scene.others, "weights": problem.aim.weights, "torque": limits.torque,
            "transition": limits.transition,
        }  # fmt: skip
        given = all_states | once
        # JSON has no infinity; what is beyond any bound is as good.
        large = {key: np.nan_to_num(value, posinf=1e9, neginf=-1e9) for key, value in given.items()}
        self._send({key: value.tolist() for key, value in large.items()})
        answer = self._receive()
        solution = self._collocation.certified(
            problem,
            np.array(answer["states"]),
            "Converged" if answer["converged"] else "Stopped",
            int(answer["iterations"]),
            bool(answer["converged"]),
        )
        return solution, Span(answer["wall"], answer["cpu"])

    def _send(self, told: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(told) + "\n")
        self._process.stdin.flush()

    def _receive(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise UnavailableError(f"its process ended with code {self._process.wait()}")
        answer: dict[str, Any] = json.loads(line)
        return answer


def _stage(collocation: Collocation) -> tuple[str, str, int]:
    """Name, library and rows of a compiled function: a state's values, then their slopes."""
    state = collocation.state
    given = [ca.SX.sym(state.name_in(i), state.size1_in(i)) for i in range(state.n_in())]
    rows = ca.vertcat(*state(*given))
    slopes = ca.densify(ca.jacobian(rows, given[0]))
    # By rows of the slopes; CasADi stores by columns.
    found = ca.vertcat(rows, ca.vec(slopes.T))
    function = ca.Function("stage", [ca.vertcat(*given)], [found], {"cse": True})
    generator = ca.CodeGenerator("stage")
    generator.add(function)
    return "stage", str(library(generator.dump())), int(rows.numel())
