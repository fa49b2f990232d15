"""How many faults of a recording are caught: two tables of docs/evidence/trust.md.

    .venv/bin/python benchmarks/caught_faults.py [--draws 50] [--clean 100] [--parity even]

Every draw takes a session of the population, made where it is missing, puts one fault into it
before anything reads it, and calibrates. A fault is caught when it is named and the session is
refused, or what it spoilt is left out. Thresholds were set on odd seeds; the page reports on even
ones. A draw that stands already is not made again, so an interrupted run goes on.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fault_cables import CABLES
from fault_draws import Draw, Expected, FaultySession, NoFaultError
from fault_physics import PHYSICS
from fault_tables import alarms, caught
from pages import ROOT, TRUST, markdown, record, write_section
from population import Member, different_robots, nao, sessions
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import errors, measured_series, truth_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import atomic_write
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.workflows.calibrate import calibrate_session

OUT = ROOT / "out" / "trust" / "faults"
FAULTS = {**CABLES, **PHYSICS}
CLEAN = "clean"
COVERED = 0.95
"""Of the spoilt samples must be left out."""
OFFSET_OFF_S = 0.01
"""A time offset is found when it is found this well."""
ATTEMPTS = 30


@dataclass(frozen=True)
class Task:
    """One draw of one fault, or a clean one."""

    fault: str
    number: int
    member: Member

    @property
    def file(self) -> Path:
        """Where its result is kept."""
        return OUT / f"{self.fault.replace(' ', '_')}_{self.member.seed % 2}_{self.number:03d}.json"


def main() -> None:
    """Make what is missing, then write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--clean", type=int, default=100)
    parser.add_argument("--parity", choices=("even", "odd"), default="even")
    parser.add_argument("--only", nargs="+", choices=(*FAULTS, CLEAN), default=(*FAULTS, CLEAN))
    parser.add_argument("--anew", action="store_true", help="forget earlier draws of these")
    args = parser.parse_args()
    half = [member for member in different_robots(200) if member.seed % 2 == (args.parity == "odd")]
    members = [member for member, _ in sessions(half[: max(args.draws, args.clean)])]
    tasks = [
        Task(fault, number, members[number % len(members)])
        for fault in args.only
        for number in range(args.clean if fault == CLEAN else args.draws)
    ]
    if args.anew:
        for task in tasks:
            task.file.unlink(missing_ok=True)
    missing = [task for task in tasks if not task.file.is_file()]
    OUT.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(os.cpu_count(), initializer=os.nice, initargs=(10,)) as pool:
        for done, told in enumerate(pool.map(_make, missing), start=1):
            print(f"{done} of {len(missing)}: {told}", flush=True)
    results = {
        fault: [json.loads(task.file.read_text()) for task in tasks if task.fault == fault]
        for fault in args.only
    }
    for fault, found in results.items():
        count = sum(one["caught"] for one in found)
        print(f"{fault}: {count} of {len(found)} {'alarms' if fault == CLEAN else 'caught'}")
    if args.parity == "even" and len(args.only) == len(FAULTS) + 1:
        tables = {
            "faults": caught({fault: results[fault] for fault in FAULTS}),
            "false-alarms": alarms(results[CLEAN]),
        }
        record("caught_faults", tables)
        for name, rows in tables.items():
            write_section(name, markdown(rows), TRUST)


def _make(task: Task) -> str:
    result = _clean(task) if task.fault == CLEAN else _faulty(task)
    atomic_write(task.file, json.dumps(result, indent=1).encode())
    return f"{task.fault} {task.number} (seed {task.member.seed}): {result['caught']}"


def _faulty(task: Task) -> dict[str, Any]:
    draw = Draw(task.fault, task.number, task.member, nao()[1])
    for _ in range(ATTEMPTS):
        try:
            injected = FAULTS[task.fault](draw)
            break
        except NoFaultError:
            draw = draw.again()
    else:
        raise ShoecalError(f"{task.fault} {task.number}: no fault in {ATTEMPTS} attempts")
    runs, expected = draw.all_runs(injected), injected.expected
    outcome, told = _calibrate(task.member, runs)
    named = _named(expected, outcome, told)
    covered = 1.0 if outcome is None else _covered(expected, outcome, runs)
    result: dict[str, Any] = {
        "seed": task.member.seed,
        "named": named,
        "refused": outcome is None,
        "covered": covered,
        "caught": named and covered >= COVERED,
        "told": told,
    }
    if outcome is not None:
        untouched = [run for run in draw.runs if run not in injected.runs] or list(draw.runs)
        found = cop_errors(task.member, outcome.stages.sensing, untouched)
        clean = clean_cop_errors(task.member)
        result["cop_mm"] = float(np.mean(list(found.values())))
        result["clean_cop_mm"] = float(np.mean([clean[run] for run in untouched]))
    return result


def _clean(task: Task) -> dict[str, Any]:
    draw = Draw(CLEAN, task.number, task.member, nao()[1])
    outcome, told = _calibrate(task.member, draw.runs)
    lost = [] if outcome is None else list(outcome.screening.left_out)
    samples = 1 if outcome is None else sum(outcome.screening.samples.values())
    alarms = outcome is None or bool(outcome.screening.findings)
    return {
        "seed": task.member.seed,
        "bits": draw.converter.bits,
        "caught": alarms,
        "left_out": sum(one.samples for one in lost) / samples,
        "told": told if alarms else "",
    }


def _calibrate(member: Member, runs: Mapping[int, Run]) -> tuple[CalibrationOutcome | None, str]:
    """The outcome, None where it is refused, and all that is told."""
    session = FaultySession.of(member.folder, runs)
    try:
        outcome = calibrate_session(session, member.train, member.test)
    except ShoecalError as error:
        return None, str(error)
    findings = [finding.reason for finding in outcome.screening.findings]
    return outcome, "; ".join([*findings, *outcome.calibration.reasons])


def _named(expected: Expected, outcome: CalibrationOutcome | None, told: str) -> bool:
    if expected.time_offset is not None:
        if outcome is None:
            return False
        off = abs(outcome.calibration.time_offset - expected.time_offset)
        return off < OFFSET_OFF_S
    if expected.words:
        return any(all(word in one for word in expected.words) for one in told.split("; "))
    if outcome is None:
        return False
    first, last = float(expected.times[0]), float(expected.times[-1])
    return any(
        one.run == expected.run
        and one.fault in expected.faults
        and any(start <= last and end >= first for start, end in one.stretches)
        for one in outcome.screening.left_out
    )


def _covered(expected: Expected, outcome: CalibrationOutcome, runs: Mapping[int, Run]) -> float:
    """Share of the spoilt samples that the fit did not see."""
    if not len(expected.times) or expected.run is None:
        return 1.0
    start_ns = outcome.data.runs[expected.run].start_ns
    assert start_ns == runs[expected.run].start_ns
    seen = [stance.time for stance in outcome.data.stances[expected.run]]
    if not seen:
        return 1.0
    period = float(np.median(np.diff(runs[expected.run].readings.time)))
    nearest = np.abs(np.concatenate(seen)[:, None] - expected.times).min(axis=0)
    return float(np.mean(nearest > period / 2.0))


def cop_errors(member: Member, sensing: Sensing, runs: Sequence[int]) -> dict[int, float]:
    """CoP error of each foot against the truth, its mean in each of some runs [mm]."""
    session = Session.open(member.folder)
    data = load_data(session, runs)
    found = {}
    for run in runs:
        truth = read_truth(session.truth_path(run))
        pairs = [
            (measured_series(sensing, stance), truth_series(truth, stance))
            for stance in data.stances[run]
        ]
        found[run] = 1e3 * float(np.mean([foot.mean for foot in errors(pairs).foot_cop]))
    return found


def clean_cop_errors(member: Member) -> dict[int, float]:
    """The same of the session as it was recorded; kept in a file."""
    file = OUT / f"seed_{member.seed:03d}.json"
    if not file.is_file():
        session = Session.open(member.folder)
        sensing = calibrate_session(session, member.train, member.test).stages.sensing
        found = cop_errors(member, sensing, [entry.run for entry in session.runs])
        OUT.mkdir(parents=True, exist_ok=True)
        atomic_write(file, json.dumps(found).encode())
    return {int(run): float(error) for run, error in json.loads(file.read_text()).items()}


if __name__ == "__main__":
    main()
