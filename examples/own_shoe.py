"""Shoes of your own: three load cells in each, simulated and calibrated.

.venv/bin/python examples/own_shoe.py --out out/examples
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli import main as shoecal
from shoecal_core.workspace import config_dir

SHOE = """format: 1
name: my_shoe
unit: mV
height_m: 0.02
converter: {lowest: -20.0, highest: 20.0}
feet:
"""
FOOT = """  %(foot)s:
    plates: {mass_above_kg: 0.04, com_above_m: [0.02, 0, 0.016],
             mass_below_kg: 0.05, com_below_m: [0.02, 0, 0.004]}
    cells:
      - {name: inner, position_m: [0.08, %(inner)s], polarity: 1}
      - {name: outer, position_m: [0.08, %(outer)s], polarity: 1}
      - {name: heel, position_m: [-0.04, 0], polarity: 1}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    (out := parser.parse_args().out).mkdir(parents=True, exist_ok=True)
    left = FOOT % {"foot": "left", "inner": -0.03, "outer": 0.03}
    right = FOOT % {"foot": "right", "inner": 0.03, "outer": -0.03}
    (out / "my_shoe.yaml").write_text(SHOE + left + right)
    words = ["simulate", str(config_dir() / "robots/nao.yaml"), str(out / "my_shoe.yaml")]
    words += ["--stance", "toes_in", "toes_out", "left_ahead", "--out", str(out / "my_session")]
    if not (out / "my_session").exists() and shoecal(words):
        raise SystemExit(1)  # why has been printed
    session = sc.Session.open(out / "my_session")
    calibration = sc.calibrate_session(session, train=(1, 2, 3)).calibration
    print(f"{calibration.verdict}: {'; '.join(calibration.reasons)}")
    series = sc.evaluate_session(session, calibration).runs[0].sources
    truth, measured = series["truth"][0], series["measured"][0]
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot(title="Force on the left foot (N) over time (s)")
    axes.plot(truth.time, truth.foot_grf[:, 0], "C0", label="true")
    axes.plot(truth.time, measured.foot_grf[:, 0], "C1--", label="calibrated")
    axes.legend()
    figure.savefig(out / "own_shoe.png")
    error = 1e3 * np.nanmedian(np.linalg.norm(measured.cop - truth.cop, axis=1))
    print(f"CoP error against the truth, median: {error:.2f} mm")


if __name__ == "__main__":
    main()
