"""Diagnose a session: which effect parts model and measurement, how large it is, what it explains.

    .venv/bin/python examples/diagnose_session.py --out out/examples [--session FOLDER]

Without --session, a simulated NAO is recorded in whose left shoe one cell bends with load.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli import main as shoecal
from shoecal_core.cli.progress import shown_progress
from shoecal_core.workspace import config_dir

BENDS = """format: 1
effects:
- {effect: nonlinearity, location: [left/front_left], quadratic_per_n: 0.012, cubic_per_n2: 0.0}
"""


def simulated(folder: Path) -> Path:
    folder.parent.mkdir(parents=True, exist_ok=True)
    (reality := folder.with_suffix(".yaml")).write_text(BENDS)
    files = [str(config_dir() / name) for name in ("robots/nao.yaml", "shoes/nao_shoe.yaml")]
    words = ["simulate", *files, "--reality", str(reality), "--out", str(folder), "--stance"]
    if folder.exists() or not shoecal([*words, "toes_in", "toes_out", "left_ahead", "right_ahead"]):
        return folder
    raise SystemExit(1)  # why has been printed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, help="folder of a recorded session")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args()
    session = sc.Session.open(args.session or simulated(args.out / "bends"))
    runs = [entry.run for entry in session.runs]
    with shown_progress() as progress:
        found = sc.diagnose(session, runs[:-1], runs[-1:], progress=progress)
    print(found.verdict)
    for cause in found.causes:
        sizes = [f"{key} {one.value:.2g} {one.unit}" for key, one in cause.size.items()]
        print(f"{cause.label}, probability {cause.probability:.0%}: {', '.join(sizes)}")
    axes = (figure := Figure(layout="constrained")).add_subplot(title="Gap, run by run")
    axes.set(xlabel="run", xticks=runs, ylabel="RMS of all signals, over their noise")
    seen = found.evidence or parser.error("no evidence to draw")
    for place, one in enumerate(filter(None, (seen.without, seen.explained))):
        gaps = [one.residuals[seen.run == run] / seen.noise for run in runs]
        heights = [np.nanmean(gap**2) ** 0.5 for gap in gaps]
        axes.bar(np.array(runs) + 0.4 * place, heights, 0.4, label=one.label)
    axes.legend()
    figure.savefig(args.out / "diagnose_session.png")


if __name__ == "__main__":
    main()
