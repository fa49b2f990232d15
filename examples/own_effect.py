"""An effect of your own in the diagnosis: a cable that lifts the robot as it leans forward.

    .venv/bin/python examples/own_effect.py --out out/examples [--session FOLDER]

Without --session, simulate_effect.py records a robot on such a cable (20 N/m) first.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli.progress import shown_progress
from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.signal_model import SignalModel
from simulate_effect import simulated


class Tether:
    """The force falls as the CoP moves forward; the CoP stays where it was."""

    identifier, group = "tether", "contact"
    components = (Component("stiffness", "N/m", 20.0),)  # with a typical size

    def places(self, _signal_model: SignalModel) -> Iterator[Place]:
        yield ()

    def shapes(self, signal_model: SignalModel, _place: Place) -> Iterator[Shape]:
        forward = signal_model.samples.cop[:, 0]
        added = signal_model.by_model(forward.mean() - forward, np.zeros((len(forward), 2)))
        yield Shape(("stiffness",), added[None])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", type=Path, help="folder of a recorded session")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args()
    session = sc.Session.open(args.session) if args.session else simulated(args.out / "tether")
    *train, test = [entry.run for entry in session.runs]
    with shown_progress() as progress:
        found = sc.diagnose(session, train, [test], effects=(*EFFECTS, Tether()), progress=progress)
    print(found.verdict)
    figure = Figure(figsize=(6, 2.5), layout="constrained")
    axes = figure.add_subplot(title="Causes: size and 95 % interval", xmargin=0.5)
    for cause in found.causes:
        for name, size in cause.size.items():
            low, high = size.ci95
            print(f"{cause.label}: {name} {size.value:.3g} ({low:.3g} to {high:.3g}) {size.unit}")
            what, half = f"{cause.label}\n{name} ({size.unit})", (high - low) / 2
            axes.errorbar(size.value, what, xerr=half, fmt="C1o")
    figure.savefig(args.out / "own_effect.png")


if __name__ == "__main__":
    main()
