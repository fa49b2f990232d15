"""What `diagnose` says of three trials of the REEM-C, each held out once.

The sensors' axes are not documented, so they are read in two ways: all parallel to the sole's, and
with both sideways forces the other way round.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pages import ROOT, Row
from shoecal_core.calibration.axes import SIDEWAYS
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import Cause, Diagnosis
from shoecal_core.recording.csv_import import import_csv
from shoecal_core.recording.session import Session

JUDGED = slice(0, 3)
"""Signals whose errors are compared: GRF and both axes of the CoP."""
SHOWN = 3
"""Of the explanations that cannot be told apart."""


def tables(
    recordings: Path,
    folder: Path,
    splits: Sequence[tuple[tuple[int, ...], int]],
    trials: Mapping[int, str],
) -> dict[str, list[Row]]:
    """By the sections of docs/evidence/real-robots.md; a row is a reading of the axes and a split.

    Args:
        recordings: of the robot.
        folder: for sessions.
        splits: runs to train and the one held out.
        trials: names of the runs.
    """
    errors: list[Row] = []
    causes: list[Row] = []
    for axes, session in _sessions(recordings, folder).items():
        for train, test in splits:
            found = diagnose(session, train, (test,))
            split = {"axes": axes, "held out": trials[test]}
            errors.append({**split, "verdict": found.verdict, **_errors(found)})
            causes.append({**split, **_causes(found)})
    return {"diagnosis": errors, "causes": causes}


def _sessions(recordings: Path, folder: Path) -> dict[str, Session]:
    """The recordings with the axes read in both ways."""
    config = folder / "config"
    shutil.copytree(ROOT / "config", config)
    shoe = config / "shoes" / "reemc.yaml"
    found = {"parallel": import_csv(config / "imports" / "reemc.yaml", recordings, folder / "a")}
    text = shoe.read_text()
    for axis in SIDEWAYS:
        text = text.replace(f"{{axis: {axis}, polarity: 1", f"{{axis: {axis}, polarity: -1")
    shoe.write_text(text)
    found["reversed"] = import_csv(config / "imports" / "reemc.yaml", recordings, folder / "b")
    return found


def _errors(diagnosis: Diagnosis) -> Row:
    """Mean errors of the held-out trial without and with the causes found.

    The excess is the mean square of GRF and CoP errors in noises, less 1.
    """
    evidence = diagnosis.evidence
    assert evidence is not None
    grf, cop, excess = [], [], []
    for fitted in (evidence.without, evidence.explained or evidence.without):
        rest = fitted.residuals[evidence.test]
        grf.append(f"{np.nanmean(np.abs(rest[:, 0])):.1f}")
        cop.append(f"{1e3 * np.nanmean(np.linalg.norm(rest[:, 1:3], axis=1)):.1f}")
        in_noises = rest[:, JUDGED] / evidence.noise[JUDGED]
        excess.append(f"{np.nanmean(in_noises**2) - 1.0:.1f}")
    return {
        "GRF (N)": " → ".join(grf),
        "CoP (mm)": " → ".join(cop),
        "CoP floor (mm)": f"{diagnosis.gap.cop_floor_mm:.1f}",
        "excess": " → ".join(excess),
    }


def _causes(diagnosis: Diagnosis) -> Row:
    rivals = (f"{one.label} {one.probability:.2f}" for one in diagnosis.ambiguity[:SHOWN])
    return {
        "causes chosen (95 % interval)": "; ".join(map(_cause, diagnosis.causes)) or "none",
        "most probable last causes": ", ".join(rivals) or "none",
    }


def _cause(cause: Cause) -> str:
    sizes = ", ".join(
        f"{name} {size.value:.3g} [{size.ci95[0]:.3g}, {size.ci95[1]:.3g}] {size.unit}".strip()
        for name, size in cause.size.items()
    )
    return f"{cause.label}: {sizes}"
