"""Compare two calibrations of one robot: which gains changed, and what the old one costs.

    .venv/bin/python examples/compare_calibrations.py --session out/examples/session

The robot of calibrate_session.py is simulated again, on a day on which one cell reads 10 % more.
"""

import argparse
import time
from pathlib import Path

from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli import main as shoecal
from shoecal_core.estimation.history import load_history
from shoecal_core.estimation.run_errors import errors_of

WARM = """format: 1
name: a warm day, and a cell whose reading grows with it
shoes: {warm_up_k: 20.0, warm_up_time_s: 0.1}
effects: [{effect: span_drift, location: [left/front_left], per_kelvin_per_k: 0.005}]
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, required=True, help="the first recording")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args()
    cold = sc.Session.open(args.session)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "warm.yaml").write_text(WARM)
    words = ["simulate", str(cold.robot_yaml), str(cold.shoe.path), "--robot-seed", "1"]
    words += ["--seed", "2", "--reality", str(args.out / "warm.yaml")]
    words += ["--stance", "toes_in", "toes_out", "left_ahead", "--out", str(args.out / "warm_day")]
    if not (args.out / "warm_day").exists() and shoecal(words):
        raise SystemExit(1)  # why has been printed
    warm = sc.Session.open(args.out / "warm_day")
    files = [args.out / "cold_calibration.yaml", args.out / "warm_calibration.yaml"]
    for session, file in zip((cold, warm), files, strict=True):
        found = sc.calibrate_session(session, made_ns=time.time_ns())
        sc.save_calibration(found.calibration, file)
    old, new = load_history(files)  # in the order of their time; changes are since the first
    channels = new.calibration.channels
    for channel, change, beyond in zip(channels, new.gain_change, new.gain_beyond, strict=True):
        print(f"{channel:<18} {change:+6.2f} %{'  changed' if beyond else ''}")
    for name, one in (("old", old), ("new", new)):
        runs = sc.evaluate_session(warm, one.calibration).runs
        error = 1e3 * errors_of(runs, "measured", "modelled").cop.mean
        print(f"CoP against the model on the warm day, {name} calibration: {error:.2f} mm")
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot(title="Change of the gains, with its 95 % interval", xlabel="%")
    axes.errorbar(new.gain_change, channels, xerr=1.96 * new.gain_change_std, fmt="C1o")
    axes.axvline(0.0, color="C0")
    figure.savefig(args.out / "compare_calibrations.png")


if __name__ == "__main__":
    main()
