"""The calibration's least squares on 1e6 samples, beside scipy's with finite differences.

    .venv/bin/python benchmarks/solve_speed.py [--samples 1000000] [--seed 1]

Both solve the same problem (samples, weights, prior, start) in the same process, in turns. The
samples are those of a simulated session, repeated with fresh noise. The extra memory is measured
in a process of its own that solves nothing else: the peak of what it holds while it solves, less
what it held before.
"""

from __future__ import annotations

import argparse
import gc
import json
import math
import os
import platform
import re
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.optimize import least_squares

import bench_json
import pages
from population import OUT, different_robots, sessions
from shoecal_core.calibration.fit import fit_parameters, prior_of
from shoecal_core.calibration.least_squares import Fit, Prior
from shoecal_core.calibration.pipeline import load_data
from shoecal_core.calibration.residuals import Weights
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.estimation.initial_guess import InitialGuess, initial_guess
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]
COMMAND = "make solve-speed"
NOISE = 0.01
"""Of the readings, as a share of each channel's standard deviation."""
OURS, SCIPY = 5, 2
"""Repetitions of each."""
FASTER, EXTRA_MB = 25.0, 100.0
"""Targets."""
SAME_COST = 1e-6
"""Relative difference of two costs that counts as none."""


@dataclass(frozen=True)
class Task:
    """What is to be solved."""

    shoe: Shoe
    stances: list[Stance]
    guess: InitialGuess
    settings: CalibrationSettings

    @property
    def samples(self) -> int:
        return sum(len(stance.time) for stance in self.stances)

    @property
    def megabytes(self) -> float:
        """What a solver reads of the samples."""
        arrays = [(s.readings, s.force, s.cop, s.cop_rate) for s in self.stances]
        return sum(array.nbytes for group in arrays for array in group) / 1e6

    def solve(self) -> Fit:
        return fit_parameters(self.shoe, self.stances, self.guess, self.settings)


def make_task(samples: int, seed: int, population: Path) -> Task:
    """A session's runs, repeated until there are enough samples."""
    member = different_robots(seed, population)[-1]
    session = next(session for _, session in sessions([member]))
    data = load_data(session)
    stances = data.of(list(data.stances))
    times = math.ceil(samples / sum(len(stance.time) for stance in stances))
    rng = np.random.default_rng(seed)
    stances = [_repeated(stance, times, rng) for stance in stances]
    return Task(
        data.shoe,
        stances,
        initial_guess(data.shoe, stances, weight_row=False),
        CalibrationSettings(),
    )


def _repeated(stance: Stance, times: int, rng: np.random.Generator) -> Stance:
    count = len(stance.time) * times
    readings = np.tile(stance.readings, (times, 1))
    for channel, size in enumerate(NOISE * stance.readings.std(axis=0)):
        readings[:, channel] += size * rng.standard_normal(count)
    return replace(
        stance,
        time=np.arange(count) * stance.duration / len(stance.time),
        readings=readings,
        force=np.tile(stance.force, times),
        cop=np.tile(stance.cop, (times, 1)),
        cop_rate=np.tile(stance.cop_rate, (times, 1)),
        angles=None,
    )


class Rows:
    """All residuals as one vector, for a solver that knows nothing of the problem."""

    def __init__(self, task: Task, prior: Prior) -> None:
        settings = task.settings
        self._weights = Weights.of(settings)
        self._stances = task.stances
        self._shares = [math.sqrt(self._weights.of_sample(stance)) for stance in task.stances]
        self._prior = prior
        self._rows = 3 * task.samples + len(prior.mean)

    def __call__(self, vector: FloatArray) -> FloatArray:
        rows = np.empty(self._rows)
        channels = len(vector) // 2
        gain, offset, time_offset = vector[:channels], vector[channels:-1], vector[-1]
        done = 0
        for stance, share in zip(self._stances, self._shares, strict=True):
            count = len(stance.time)
            constant = offset @ stance.columns + stance.base
            force, mx, my = (stance.readings @ (gain[:, None] * stance.columns) + constant).T
            own = rows[done : done + 3 * count].reshape(3, count)
            own[0] = (share / self._weights.force) * (force - stance.force)
            expected = stance.cop + time_offset * stance.cop_rate
            own[1] = (share / self._weights.cop) * (-my / force - expected[:, 0])
            own[2] = (share / self._weights.cop) * (mx / force - expected[:, 1])
            done += 3 * count
        rows[done:] = (vector - self._prior.mean) / self._prior.std
        return rows

    def solve(self) -> FloatArray:
        """As a careful user would: one call a Jacobian column, parameters scaled alike."""
        found = least_squares(self, self._prior.mean, x_scale=self._prior.std)
        solution: FloatArray = found.x
        return solution


Result = TypeVar("Result")


def timed(function: Callable[[], Result]) -> tuple[tuple[float, float], Result]:
    """Seconds by the clock and of the processor, and the result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    return (time.perf_counter() - wall, time.process_time() - cpu), result


def status(field: str) -> float:
    """A field of this process's memory as the kernel counts it [MB]."""
    text = Path("/proc/self/status").read_text()
    found = re.search(rf"^{field}:\s+(\d+) kB$", text, re.MULTILINE)
    assert found is not None, f"the kernel tells no {field}"
    return int(found.group(1)) * 1024 / 1e6


def extra_memory(task: Task) -> dict[str, float]:
    """What solving takes beyond the data [MB]: by the kernel, and by Python's allocator."""
    gc.collect()
    before = status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    task.solve()
    resident = status("VmHWM") - before
    tracemalloc.start()
    task.solve()
    traced = tracemalloc.get_traced_memory()[1] / 1e6
    return {"resident": resident, "traced": traced}


def compare(task: Task) -> dict[str, float]:
    """Time and cost of both solvers."""
    rows = Rows(task, prior_of(task.shoe, task.guess, task.settings))
    ours, theirs = [], []
    for turn in range(OURS):
        seconds, fit = timed(task.solve)
        ours.append(seconds)
        print(f"shoecal: {seconds[0]:.2f} s, cost {fit.cost:.6f}", flush=True)
        if turn < SCIPY:
            seconds, solution = timed(rows.solve)
            theirs.append(seconds)
            cost = float(np.sum(rows(solution) ** 2))
            print(f"scipy: {seconds[0]:.1f} s, cost {cost:.6f}", flush=True)
    own = float(np.sum(rows(fit.vector) ** 2))
    wall, cpu = np.median(ours, axis=0)
    scipy_wall, scipy_cpu = np.median(theirs, axis=0)
    return {
        "samples": task.samples,
        "seconds": wall,
        "cpu_seconds": cpu,
        "scipy_fd_seconds": scipy_wall,
        "scipy_fd_cpu_seconds": scipy_cpu,
        "vs_scipy_fd": scipy_wall / wall,
        "vs_scipy_fd_cpu": scipy_cpu / cpu,
        "cost_difference": (own - cost) / cost,
        "data_mb": task.megabytes,
    }


BODY = """\
## Least squares of {millions:.3g} million samples

Made by `{command}`.

{samples:.0f} samples of a simulated NAO's session, repeated with fresh noise; eight gains and
offsets and the time offset; same weights, prior and start.

{table}

**{vs_scipy_fd:.0f} times** faster by the clock, {vs_scipy_fd_cpu:.0f} times in processor time
(median of {ours} runs against {scipy}, alternating, one process). Relative cost difference:
{cost_difference:.1e}.

The data take {data_mb:.0f} MB. Extra memory is the peak while solving in a process of its own:
the larger of {resident:.1f} MB resident and {traced:.1f} MB allocated by Python.

The normal equations are sums of weighted moments, taken in chunks without a Jacobian; fits to a
hundredth and a tenth of the samples leave two or three passes over all.

Measured on {cores} cores ({machine}), OPENBLAS_NUM_THREADS {threads}, with Python {python}, numpy
{numpy}, scipy {scipy_version}.
"""


def body(figures: dict[str, float], memory: dict[str, float]) -> str:
    """The section of docs/evidence/performance.md."""
    rows = [
        [name, *(f"{figures[field]:.2f}" for field in fields), memory_mb]
        for name, fields, memory_mb in (
            ("shoecal", ("seconds", "cpu_seconds"), f"{figures['extra_mb']:.1f}"),
            (
                "`scipy.optimize.least_squares`, finite differences",
                ("scipy_fd_seconds", "scipy_fd_cpu_seconds"),
                "not measured",
            ),
        )
    ]
    return BODY.format(
        **figures,
        **memory,
        table=pages.table(
            [["solver", "time [s]", "processor time [s]", "extra memory [MB]"], *rows]
        ),
        millions=figures["samples"] / 1e6,
        command=COMMAND,
        ours=OURS,
        scipy=SCIPY,
        cores=os.cpu_count(),
        machine=platform.machine(),
        threads=os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        python=platform.python_version(),
        numpy=np.__version__,
        scipy_version=scipy.__version__,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--population", type=Path, default=OUT)
    parser.add_argument("--memory", action="store_true", help="only the memory, as JSON")
    args = parser.parse_args(arguments)
    task = make_task(args.samples, args.seed, args.population)
    if args.memory:
        print(json.dumps(extra_memory(task)))
        return 0
    command = [sys.executable, __file__, "--memory", "--samples", str(args.samples)]
    command += ["--seed", str(args.seed), "--population", str(args.population)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    memory: dict[str, float] = json.loads(told.splitlines()[-1])
    figures = compare(task) | {"extra_mb": max(memory.values())}
    bench_json.record("calibration", figures)
    pages.write_performance("solve", body(figures, memory))
    print(json.dumps(figures, indent=1))
    met = {
        f"at least {FASTER:g} times faster": figures["vs_scipy_fd"] >= FASTER,
        f"at most {EXTRA_MB:g} MB more": figures["extra_mb"] <= EXTRA_MB,
        "to the same cost": figures["cost_difference"] <= SAME_COST,
    }
    for target in (target for target, reached in met.items() if not reached):
        print(f"missed: {target}")
    return 0 if all(met.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
