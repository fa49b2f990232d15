"""Calibrate and diagnose a real humanoid's ankle sensors: tables of docs/evidence/real-robots.md.

    .venv/bin/python benchmarks/real_robots.py FOLDER

FOLDER holds the recordings of the REEM-C: reemc.urdf, stepping/, walk_a/ to walk_g/. They are not
part of this project (eurobench/eb_hum_bench publishes them under a BSD licence).
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import real_diagnosis
import real_trials
from pages import EVIDENCE, ROOT, Row, markdown, write_section
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import Errors, errors, measured_series, modelled_series
from shoecal_core.parameter_file import load_settings
from shoecal_core.recording.imports.csv_import import import_csv
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workflows.calibrate import calibrate_session

IMPORTS = ROOT / "config" / "imports"
SPLITS = (((1, 2), 3), ((1, 3), 2), ((2, 3), 1))
TRIALS = {1: "stepping", 2: "walking a", 3: "walking b"}


def main() -> None:
    """Import, calibrate every split, write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--doc", type=Path, default=EVIDENCE / "real-robots.md")
    args = parser.parse_args()
    settings = load_settings(
        CalibrationSettings, IMPORTS / "reemc_calibrator.yaml", "calibrator", "calibration"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        session = import_csv(IMPORTS / "reemc.yaml", args.folder, folder / "session")
        outcomes = [
            calibrate_session(session, train, (test,), settings, rezero=True)
            for train, test in SPLITS
        ]
        tables: dict[str, Sequence[Row]] = {
            "splits": [_split(outcome) for outcome in outcomes],
            "checks": [
                {"checks of the first split": one} for one in outcomes[0].calibration.reasons
            ],
            **real_trials.tables(session, settings),
            **real_diagnosis.tables(session),
        }
    for name, rows in tables.items():
        write_section(name, markdown(rows), args.doc)


def _split(outcome: CalibrationOutcome) -> Row:
    """Errors of the held-out trial by the published readings as they are, and calibrated."""
    count, test = len(outcome.data.shoe.names), outcome.data.of(outcome.test)
    raw = Sensing(outcome.data.shoe, ChannelParameters(np.ones(count), np.zeros(count)))
    pairs = [(measured_series(raw, one), modelled_series(one)) for one in test]
    off = np.concatenate([measured.grf - modelled.grf for measured, modelled in pairs])
    return {
        "fitted on": " + ".join(TRIALS[run] for run in outcome.train),
        "held out": TRIALS[outcome.test[0]],
        **_errors(errors(pairs), "before"),
        **_errors(outcome.modelled["self_calibration"]["test"], "after"),
        "mean GRF before (N)": f"{off.mean():+.0f}",
    }


def _errors(found: Errors, when: str) -> Row:
    return {
        f"GRF {when} (N)": f"{found.grf.mean:.1f} ± {found.grf.std:.1f}",
        f"CoP {when} (mm)": f"{1e3 * found.cop.mean:.1f} ± {1e3 * found.cop.std:.1f}",
    }


if __name__ == "__main__":
    main()
