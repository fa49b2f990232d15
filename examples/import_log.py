"""Import a log in CSV, as a data logger writes it: degrees and millivolts, one row a sample.

    .venv/bin/python examples/import_log.py --session out/examples/session --out out/examples
Here the log is written from a recorded session; of your own you need the mapping only.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.files import write_yaml
from shoecal_core.recording.imports.csv_import import import_csv
from shoecal_core.recording.run import Run


def write_log(run: Run, file: Path) -> None:
    joints, cells = run.joints, run.readings
    angles, valid = sc.interpolate_joints(joints, cells.time, max_gap_s=0.1, names=joints.names)
    table = np.column_stack([cells.time, np.degrees(angles), 1e3 * cells.value])[valid]
    header = ",".join(["t", *joints.names, *cells.names])
    np.savetxt(file, table, "%.7g", ",", header=header, comments="")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, required=True, help="to write the log from")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args()
    session, logs, trials = sc.Session.open(args.session), args.out / "logs", []
    logs.mkdir(parents=True, exist_ok=True)
    for entry in session.runs:
        write_log(session.read(entry.run), logs / f"{entry.run}.csv")
        feet = entry.info.support or parser.error("the session has a walk; name another one")
        pose = [round(number, 2) for number in (feet.dx, feet.dy, feet.dtheta)]  # tape measure
        trials.append({"motion": "-", "support": pose, "files": {"log": f"{entry.run}.csv"}})
    files = {"robot": session.robot_yaml, "urdf": session.robot_urdf, "shoe": session.shoe.path}
    mapping: dict[str, object] = {name: str(path.resolve()) for name, path in files.items()}
    cells = {name: {"column": name, "scale": 0.001} for name in session.shoe.names}
    table = {"time": {"column": "t", "unit": "s"}, "joints": "all", "cells": cells}
    mapping |= {"format": 1, "angle_unit": "deg", "tables": {"log": table}, "trials": trials}
    write_yaml(file := logs / "mapping.yaml", mapping)
    folder = args.out / "imported"  # made once
    imported = sc.Session.open(folder) if folder.exists() else import_csv(file, logs, folder)
    calibration = sc.calibrate_session(imported).calibration
    print(f"{len(imported.runs)} runs; {calibration.verdict}: {'; '.join(calibration.reasons)}")
    sc.save_calibration(calibration, args.out / "imported.yaml")
    series = sc.evaluate_session(imported, calibration).runs[0].sources
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot(title="CoP of an imported run, forward (mm) over time (s)")
    for source, label, colour in (("modelled", "model", "C0"), ("measured", "calibrated", "C1")):
        axes.plot(series[source][0].time, 1e3 * series[source][0].cop[:, 0], colour, label=label)
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(args.out / "import_log.png")


if __name__ == "__main__":
    main()
