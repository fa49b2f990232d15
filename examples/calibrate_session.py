"""Calibrate a session: gains, CoP error, and a picture of a run that was not fitted.

    .venv/bin/python examples/calibrate_session.py --out out/examples [--session FOLDER]

Without --session, four runs of a simulated NAO are recorded first.
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli import main as shoecal
from shoecal_core.workspace import config_dir


def simulated(folder: Path) -> Path:
    """Record a simulated NAO in four double supports, as `shoecal simulate` does."""
    files = [str(config_dir() / name) for name in ("robots/nao.yaml", "shoes/nao_shoe.yaml")]
    stances = ["toes_in", "toes_out", "left_ahead", "right_ahead"]
    words = ["simulate", *files, "--stance", *stances, "--out", str(folder)]
    if not folder.exists() and shoecal(words):
        raise SystemExit(1)  # why has been printed
    return folder


def main() -> None:
    """Calibrate by all runs but the last, and test on that one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, help="folder of a recorded session")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args()
    session = sc.Session.open(args.session or simulated(args.out / "session"))
    *train, test = [entry.run for entry in session.runs]
    outcome = sc.calibrate_session(session, train, [test])
    calibration = outcome.calibration
    sc.save_calibration(calibration, args.out / "calibration.yaml")
    print(f"{calibration.verdict}: {'; '.join(calibration.reasons)}")
    for channel, gain in zip(calibration.channels, calibration.parameters.gain, strict=True):
        print(f"  {channel:<18} {gain:8.3f} N/{session.shoe.unit}")
    for stage, errors in outcome.modelled.items():  # initial_guess, self_calibration
        print(f"CoP error of the test run, {stage}: {1e3 * errors['test'].cop.mean:.2f} mm")

    (run,) = sc.evaluate_session(session, calibration, train=train, test=[test]).runs[-1:]
    figure = Figure(figsize=(6, 5), layout="constrained")
    axes = figure.add_subplot(title=f"CoP of run {test}, which was not fitted", aspect="equal")
    axes.set(xlabel="y, to the left (mm)", ylabel="x, forward (mm)")
    axes.invert_xaxis()  # the robot looks up the page
    for source, label, colour in (("modelled", "model", "C0"), ("measured", "calibrated", "C1")):
        cop = 1e3 * run.sources[source][0].cop  # of the run's only stance
        axes.plot(cop[:, 1], cop[:, 0], colour, label=label)
    axes.legend()
    figure.savefig(args.out / "calibrate_session.png")


if __name__ == "__main__":
    main()
