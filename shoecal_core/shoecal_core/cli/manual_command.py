"""`shoecal manual cells|shoe DATA` and `shoecal manual simulate`: calibration by known weights."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from rich.console import Console

from shoecal_core.arrays import FloatArray
from shoecal_core.cli.arguments import (
    add_json,
    add_shoe,
    require_folder,
    seed_number,
    shoe_file,
)
from shoecal_core.cli.manual_guide import guide_person
from shoecal_core.cli.manual_guide_streams import FrameStream, driver_stream, file_stream
from shoecal_core.cli.manual_tables import cells_to_json, manual_to_json
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import of_page, print_table
from shoecal_core.cli.usable import require_usable
from shoecal_core.errors import FileMissingError, ShoecalError
from shoecal_core.estimation.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.files import make_folder
from shoecal_core.manual.calibrate import (
    CellsCalibration,
    FootResult,
    ManualCalibration,
    calibrate_cells,
    calibrate_shoe,
    of_shoe,
)
from shoecal_core.manual.cells import CellFit
from shoecal_core.manual.guide import Check, Guide, cell_check, shoe_check
from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.manual.measurements import Measurements
from shoecal_core.manual.measurements_file import load_measurements, save_measurements
from shoecal_core.manual.settings import ManualSettings, load_manual_settings
from shoecal_core.report.calibration.manual_report import (
    ManualReport,
    cells_table,
    loads_table,
    manual_report,
)
from shoecal_core.report.next_step import after_calibration, after_cells
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import foot_wrenches
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.simulated_manual import simulate_manual
from shoecal_core.workspace import config_dir

CELLS_DATA, SHOE_DATA = "cells_data.yaml", "shoe_data.yaml"
CELLS_FILE, CALIBRATION_FILE = "cells.yaml", "calibration.yaml"
"""Files of a folder that `simulate` makes; CELLS_FILE is also looked for next to the data."""

SIMULATED = "Shoes, weights and the bench are simulated."


@dataclass(frozen=True)
class _Bench:
    """What is calibrated, and with what."""

    shoe: Shoe
    robot: Robot
    settings: ManualSettings

    @property
    def planned(self) -> int:
        """Loads of one shoe in a whole calibration, the bare one aside."""
        holes = max((len(foot.names) for foot in self.shoe.holes if foot is not None), default=0)
        return holes * len(self.settings.shoe_weights)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its tasks and their arguments."""
    tasks = parser.add_subparsers(dest="task", metavar="cells|shoe|simulate", required=True)
    cells = tasks.add_parser(CELLS, help="gains and offsets from single cells under known weights")
    shoe = tasks.add_parser(SHOE, help="offsets and CoP correction from weights on the shoe")
    for task in (cells, shoe):
        task.add_argument("data", type=Path, help="file of the readings; a guided session fills it")
        task.add_argument(
            "--out", type=Path, metavar="FILE", required=True, help="calibration file to write"
        )
        source = task.add_mutually_exclusive_group()
        source.add_argument(
            "--live", action="store_true", help="guide a person, with the running driver's voltages"
        )
        source.add_argument(
            "--from",
            dest="source",
            type=Path,
            metavar="FILE",
            help="guide a person, with lines of readings (JSON or CSV) from a file or pipe",
        )
        task.add_argument(
            "--foot",
            choices=FEET,
            help="guide through one shoe only, and calibrate it alone where DATA has no other",
        )
    shoe.add_argument(
        "--cells",
        type=Path,
        metavar="FILE",
        help=f"what `manual cells` wrote (default: {CELLS_FILE} next to DATA)",
    )
    simulate = tasks.add_parser("simulate", help="a simulated bench does the person's part")
    simulate.add_argument(
        "--out", type=Path, metavar="DIR", required=True, help="folder to make the files in"
    )
    simulate.add_argument("--seed", type=seed_number, default=1, help="draws noise and placement")
    simulate.add_argument(
        "--robot-seed",
        type=seed_number,
        help="draws the cells (default: the seed): those of a simulated session's robot",
    )
    simulate.add_argument(
        "--reality", type=Path, metavar="FILE", help="changes to the default simulated reality"
    )
    for task in (cells, shoe, simulate):
        task.add_argument(
            "--robot", type=Path, metavar="FILE", help="who wears the shoes (default: the NAO)"
        )
        add_shoe(task)
        task.add_argument(
            "--settings",
            type=Path,
            metavar="FILE",
            help="weights and samples (default: manual.yaml)",
        )
        task.add_argument("--report", type=Path, metavar="FILE", help="also write an HTML report")
        add_json(task)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Do one of the tasks."""
    config = config_dir()
    robot = args.robot or config / "robots" / "nao.yaml"
    shoe = load_shoe(shoe_file(args, robot), partial=args.task != "simulate")
    bench = _Bench(
        shoe,
        load_robot(robot, shoe),
        load_manual_settings(args.settings or config / "manual.yaml"),
    )
    for path in filter(None, (args.json, args.report)):
        require_folder(path)
    if args.task == "simulate":
        return _simulate(args, bench, console)
    require_folder(args.out)
    if args.foot is not None and FEET.index(args.foot) not in shoe.feet:
        raise ShoecalError(f"--foot {args.foot}: {shoe.path} has no {args.foot} shoe")
    if args.task == CELLS:
        cells = _measured(args, bench, console, cell_check, partial(_shown_cell, shoe))
        cells = _without_missing_foot(args, cells)
        bench = replace(bench, shoe=cells.shoe)
        result = _solve_cells(bench, cells, console)
        _report(args.report, bench, result.calibration, result.cells, (), _read_from(args.data))
        figures = cells_to_json(result)
        _write(result.calibration, figures, args.out, console, after_cells)
        return figures
    first = _first_step(args)
    asked = shoe if args.foot is None else shoe.of_one_foot(FEET.index(args.foot))
    of_shoe(first, asked)  # before anybody is asked to carry a weight
    loads = _measured(args, bench, console, shoe_check(first), partial(_shown_force, shoe, first))
    loads = _without_missing_foot(args, loads)
    bench = replace(bench, shoe=loads.shoe)
    found = _solve_shoe(bench, of_shoe(first, loads.shoe), loads, (), console)
    _report(args.report, bench, found.calibration, (), found.feet, _read_from(args.data))
    figures = manual_to_json(found)
    _write(found.calibration, figures, args.out, console, after_calibration)
    return figures


def _without_missing_foot(args: argparse.Namespace, read: Measurements) -> Measurements:
    """With --foot, where no other foot was read: that foot's shoe alone."""
    if args.foot is None:
        return read
    foot = FEET.index(args.foot)
    if any(entry.load.foot != foot for entry in read.entries):
        return read
    return replace(read, shoe=read.shoe.of_one_foot(foot))


def _measured(
    args: argparse.Namespace,
    bench: _Bench,
    console: Console,
    check: Check,
    shown: Callable[[Load, FloatArray], str],
) -> Measurements:
    """The readings that stand in the file; first the missing ones are read, where asked for."""
    kind, path, shoe = args.task, args.data, bench.shoe
    guided = args.live or args.source is not None
    if not guided and not path.exists():
        raise FileMissingError(
            path, "does not exist; --live (or --from FILE) guides through the readings and makes it"
        )
    feet = shoe.feet if args.foot is None else (FEET.index(args.foot),)
    plan = planned_loads(kind, shoe, bench.settings.weights(kind), feet)
    measurements = Measurements(kind, shoe)
    if path.exists():
        measurements = load_measurements(path, kind, shoe)
    if not guided:
        return measurements
    require_folder(path)
    guide = Guide(plan, measurements, bench.settings, check)
    source: AbstractContextManager[FrameStream] = (
        driver_stream(shoe) if args.live else file_stream(args.source, shoe)
    )
    with source as stream:
        guide_person(guide, stream, lambda whole: save_measurements(whole, path), shown, console)
    return load_measurements(path, kind, shoe)


def _first_step(args: argparse.Namespace) -> Calibration:
    """The cells' calibration."""
    path = args.cells or args.data.with_name(CELLS_FILE)
    if args.cells is None and not path.exists():
        raise FileMissingError(
            path, "does not exist; give with --cells what `shoecal manual cells` has written"
        )
    return load_calibration(path)


def _simulate(args: argparse.Namespace, bench: _Bench, console: Console) -> Mapping[str, object]:
    """Both steps on the simulated bench."""
    reality = load_reality(config_dir() / "realities" / "default.yaml", args.reality)
    robot_seed = args.seed if args.robot_seed is None else args.robot_seed
    cells, loads = simulate_manual(bench.shoe, reality, robot_seed, args.seed, bench.settings)
    folder = args.out
    make_folder(folder)
    save_measurements(cells, folder / CELLS_DATA)
    save_measurements(loads, folder / SHOE_DATA)
    first = _solve_cells(bench, cells, console)
    _write(first.calibration, cells_to_json(first), folder / CELLS_FILE, console)
    saved = load_calibration(folder / CELLS_FILE)
    found = _solve_shoe(bench, saved, loads, first.cells, console)
    _report(args.report, bench, found.calibration, found.cells, found.feet, (SIMULATED,))
    figures = {**manual_to_json(found), "seed": args.seed, "robot_seed": robot_seed}
    calibration_file = folder / CALIBRATION_FILE
    _write(found.calibration, figures, calibration_file, console, after_calibration)
    return figures


def _solve_cells(bench: _Bench, cells: Measurements, console: Console) -> CellsCalibration:
    result = calibrate_cells(bench.shoe, bench.robot, cells)
    content = ManualReport(bench.robot, bench.shoe, result.calibration, result.cells)
    print_table(console, of_page(cells_table(content)))
    return result


def _solve_shoe(
    bench: _Bench,
    first: Calibration,
    loads: Measurements,
    fits: tuple[CellFit, ...],
    console: Console,
) -> ManualCalibration:
    result = calibrate_shoe(bench.shoe, bench.robot, first, loads, fits=fits, planned=bench.planned)
    content = ManualReport(bench.robot, bench.shoe, result.calibration, result.cells, result.feet)
    print_table(console, of_page(loads_table(content)))
    return result


def _read_from(data: Path) -> tuple[str, ...]:
    """Where readings are from, as shown in a report."""
    return (
        "Nothing in the readings says that they were simulated: taken as read on hardware.",
        f"Readings: {data.name}.",
    )


def _report(
    path: Path | None,
    bench: _Bench,
    calibration: Calibration,
    cells: Sequence[CellFit],
    feet: Sequence[FootResult],
    provenance: tuple[str, ...],
) -> None:
    """Write it where one is asked for; of a calibration that must not be used, too."""
    if path is not None:
        manual_report(
            path, ManualReport(bench.robot, bench.shoe, calibration, cells, feet, provenance)
        )


def _write(
    calibration: Calibration,
    figures: Mapping[str, object],
    out: Path,
    console: Console,
    following: Callable[[str, str], str] | None = None,
) -> None:
    """Save it, and say what follows; one with the verdict FAIL is not written."""
    require_usable(calibration, figures, console)
    save_calibration(calibration, out)
    say(console, f"{out}")
    if following is not None:
        say(console, following(calibration.verdict, str(out)))


def _shown_cell(shoe: Shoe, load: Load, readings: FloatArray) -> str:
    return f"{load.place} {readings[shoe.index(load.place)]:.5g} {shoe.unit}"


def _shown_force(shoe: Shoe, cells: Calibration, load: Load, readings: FloatArray) -> str:
    one = shoe.of_one_foot(load.foot)
    outputs = of_shoe(cells, one).parameters.outputs(readings[shoe.of_foot(load.foot)])
    return f"{FEET[load.foot]} shoe {foot_wrenches(one, outputs)[load.foot, 0]:.2f} N"
