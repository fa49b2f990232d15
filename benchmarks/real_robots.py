"""Calibrate and diagnose a real humanoid's ankle sensors; write docs/evidence/real-robots.md.

    .venv/bin/python benchmarks/real_robots.py FOLDER

FOLDER holds the recordings of the REEM-C: reemc.urdf, stepping/, walk_a/ to walk_g/. They are not
part of this project (eurobench/eb_hum_bench publishes them under a BSD licence).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import real_diagnosis
import real_trials
from shoecal_core.calibration.evaluate import Errors, errors, measured_series, modelled_series
from shoecal_core.calibration.pipeline import Outcome, calibrate_session
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.recording.csv_import import import_csv
from shoecal_core.sensing.sensing import Sensing
from shoecal_core.sensing.wrench import ChannelParameters
from shoecal_core.settings import load_settings

ROOT = Path(__file__).resolve().parents[1]
IMPORTS = ROOT / "config" / "imports"
SPLITS = (((1, 2), 3), ((1, 3), 2), ((2, 3), 1))
TRIALS = {1: "stepping", 2: "walking a", 3: "walking b"}


def main() -> int:
    """Import, calibrate every split, write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--doc", type=Path, default=ROOT / "docs" / "evidence" / "real-robots.md")
    args = parser.parse_args()
    settings = load_settings(
        CalibrationSettings, IMPORTS / "reemc_calibrator.yaml", "calibrator", "calibration"
    )
    with tempfile.TemporaryDirectory() as folder:
        session = import_csv(IMPORTS / "reemc.yaml", args.folder, Path(folder) / "session")
        outcomes = [
            calibrate_session(session, train, (test,), settings, rezero=True)
            for train, test in SPLITS
        ]
        diagnosis = real_diagnosis.section(args.folder, Path(folder), SPLITS, TRIALS)
        trials = real_trials.section(session, settings)
        args.doc.write_text(_page(outcomes, trials, diagnosis))
    print(args.doc)
    return 0


def _page(outcomes: list[Outcome], trials: str, diagnosis: str) -> str:
    rows = [_row(outcome) for outcome in outcomes]
    first = outcomes[0]
    parameters, shoe = first.stages.parameters, first.data.shoe
    vertical = [index for index, name in enumerate(shoe.names) if name.endswith("/fz")]
    gain = float(np.mean(parameters.gain[vertical]))
    return PAGE.format(
        trials=trials,
        diagnosis=diagnosis,
        rows="\n".join(rows),
        gain=gain,
        trained=_trials(first),
        bias=", ".join(
            f"{_bias(outcome):+.0f} N ({TRIALS[outcome.test[0]]})" for outcome in outcomes
        ),
        reasons="; ".join(first.calibration.reasons),
        channels="\n".join(
            f"| {name} | {slope:.2f} | {offset:.1f} |"
            for name, slope, offset in zip(
                shoe.names, parameters.gain, parameters.offset, strict=True
            )
        ),
    )


def _raw(outcome: Outcome) -> Sensing:
    """The published readings as they are."""
    count = len(outcome.data.shoe.names)
    return Sensing(outcome.data.shoe, ChannelParameters(np.ones(count), np.zeros(count)))


def _bias(outcome: Outcome) -> float:
    """Mean of measured minus modelled vertical force on the held-out trial [N]."""
    raw = _raw(outcome)
    off = [measured_series(raw, one).grf - one.force for one in outcome.data.of(outcome.test)]
    return float(np.concatenate(off).mean())


def _row(outcome: Outcome) -> str:
    raw, test = _raw(outcome), outcome.data.of(outcome.test)
    before = errors([(measured_series(raw, one), modelled_series(one)) for one in test])
    after = outcome.modelled["self_calibration"]["test"]
    cells = [_trials(outcome), TRIALS[outcome.test[0]], *_cells(before), *_cells(after)]
    return f"| {' | '.join(cells)} |"


def _trials(outcome: Outcome) -> str:
    return " + ".join(TRIALS[run] for run in outcome.train)


def _cells(found: Errors) -> list[str]:
    return [
        f"{found.grf.mean:.1f} ± {found.grf.std:.1f}",
        f"{1e3 * found.cop.mean:.1f} ± {1e3 * found.cop.std:.1f}",
    ]


PAGE = """\
# Real robots

Computed from recordings of real hardware by

    .venv/bin/python benchmarks/real_robots.py FOLDER

where FOLDER holds the recordings (not part of this project). One split by hand:

    .venv/bin/shoecal import csv config/imports/reemc.yaml FOLDER --out out/reemc
    .venv/bin/shoecal calibrate out/reemc --train 1,2 --test 3 \\
        --settings config/imports/reemc_calibrator.yaml --out out/reemc_calibration.yaml

## REEM-C: six-axis sensors in the ankles

Eight trials at 50 Hz of a humanoid of 1.65 m, published by eurobench/eb_hum_bench (BSD): slow
stepping and seven walks. Axes and offsets of the sensors are not documented; the axes are assumed
parallel to the sole's. There was no force plate, so **the reference is the model**, not a truth:
weight and CoM of the URDF, accelerations from joint angles and recorded base pose, CoP as
zero-moment point.

Stances are detected: a foot hangs where joints and base pose lift its whole sole and its sensor
reads what it reads whenever the foot is highest; then its wrench is zero. A foot stands if it is
flat, still and loaded. Two of the first three trials are fitted, the third is predicted with its
own zeros. MAE ± standard deviation over all samples of the held-out trial's stances:

| fitted on | held out | GRF before (N) | CoP before (mm) | GRF after (N) | CoP after (mm) |
|---|---|---|---|---|---|
{rows}

*Before*: the published readings as they are (gain 1, offset 0).

The vertical gains are near {gain:.2f} instead of 1: a wrong mass looks like a common gain.

The checks of the first split say: {reasons}.

Gains and offsets (fitted on {trained}):

| channel | gain | offset (N, N m) |
|---|---|---|
{channels}

{trials}{diagnosis}### What stays open

The robot's weight; axes and positions of the sensors; load sharing in double support. The base
pose is an estimate, and soles are assumed rigid and flat. Per sample (first table) the CoP of
walking is centimetres off, because the model misses accelerations within a step; per step it is
not. As published, the readings' vertical sum is off the model by {bias} on average.
"""


if __name__ == "__main__":
    sys.exit(main())
