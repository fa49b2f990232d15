"""`shoecal evaluate SESSION --calibration FILE`: how far a calibration is off.

Against the model always; against the simulator's truth where the session has one; against
another calibration where one is given.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from rich.console import Console

from shoecal_core.calibration.calibration import load_calibration
from shoecal_core.calibration.comparison import read_truths
from shoecal_core.calibration.evaluate import (
    Series,
    errors,
    measured_series,
    modelled_series,
    truth_series,
)
from shoecal_core.calibration.pipeline import load_data, split_runs
from shoecal_core.calibration.stance import Stance
from shoecal_core.commands.arguments import add_sets
from shoecal_core.commands.tables import errors_table, stages_rows
from shoecal_core.recording.session import Session


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of the recorded session")
    parser.add_argument("--calibration", type=Path, required=True, help="the one to judge")
    parser.add_argument("--reference", type=Path, help="a calibration taken as right")
    add_sets(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Compare on every run, by set."""
    session = Session.open(args.session)
    train, test = split_runs(session, args.train, args.test)
    data = load_data(session, (*train, *test))
    sensing = load_calibration(args.calibration).sensing(data.shoe)
    references: dict[str, Callable[[Stance], Series]] = {"modelled": modelled_series}
    if args.reference is not None:
        reference = load_calibration(args.reference).sensing(data.shoe)
        references["reference"] = partial(measured_series, reference)
    truths = read_truths(session, data)
    if truths.keys() == data.stances.keys():
        references["truth"] = lambda stance: truth_series(truths[stance.run], stance)
    found = {
        f"against_{name}": {
            part: errors([(measured_series(sensing, s), reference_of(s)) for s in data.of(runs)])
            for part, runs in (("train", train), ("test", test))
            if runs
        }
        for name, reference_of in references.items()
    }
    console.print(errors_table("Measured", stages_rows(found)))
    return {
        name: {part: error.to_json() for part, error in sets.items()}
        for name, sets in found.items()
    }
