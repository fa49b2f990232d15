"""`shoecal history CALIBRATION.yaml ...`: how a robot's gains and offsets changed over time."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from shoecal_core.cli.arguments import require_folder
from shoecal_core.cli.tables import LEVELS, new_table, print_table
from shoecal_core.estimation.history import HistoryEntry, load_history, made_text
from shoecal_core.shoe.shoe import FEET


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument(
        "calibrations",
        type=Path,
        nargs="+",
        metavar="CALIBRATION",
        help="calibration files of one robot and one shoe, in any order",
    )
    parser.add_argument("--report", type=Path, metavar="FILE", help="also write an HTML report")


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Compare each with the oldest."""
    if args.report is not None:
        require_folder(args.report)
    history = load_history(args.calibrations)
    print_table(console, _table(history))
    if args.report is not None:
        # Loaded where a report is asked for: the table alone is quick.
        from shoecal_core.report.history_report import history_report  # noqa: PLC0415

        history_report(args.report, history)
    first = history[0].calibration
    return {
        "format": 1,
        "robot": first.robot,
        "shoe": first.shoe,
        "calibrations": [_figures(entry) for entry in history],
    }


def _table(history: Sequence[HistoryEntry]) -> Table:
    first = history[0].calibration
    table = new_table(f"{first.robot} on {first.shoe}: changes against the first (*: > 2 std)")
    for name in ("date (UTC)", "id", "verdict", "largest gain change", "largest zero change",
                 "zeros left, right (N)"):  # fmt: skip
        table.add_column(name)
    for entry in history:
        one, force = entry.calibration, entry.force_channels
        gain = int(np.argmax(np.abs(entry.gain_change)))
        zero = int(force[np.argmax(np.abs(entry.offset_change[force]))]) if len(force) else gain
        mark = ("*" if entry.gain_beyond[gain] else "", "*" if entry.offset_beyond[zero] else "")
        table.add_row(
            made_text(one),
            one.id,
            f"[{LEVELS[one.verdict]}]{one.verdict}[/]",
            f"{entry.gain_change[gain]:+.1f} %{mark[0]} ({one.channels[gain]})",
            f"{entry.offset_change[zero]:+.2f} N{mark[1]} ({one.channels[zero]})",
            ", ".join(f"{entry.zero_sum(foot):+.1f}" for foot in FEET),
        )
    return table


def _figures(entry: HistoryEntry) -> dict[str, object]:
    one = entry.calibration
    return {
        "file": str(entry.path),
        "id": one.id,
        "made_ns": one.made_ns,
        "verdict": one.verdict,
        "temperature_degc": _known(one.temperature),
        "zero_sum_n": {foot: entry.zero_sum(foot) for foot in FEET},
        "channels": [
            {
                "name": name,
                "gain": float(one.parameters.gain[index]),
                "gain_std": _known(entry.gain_std[index]),
                "gain_change_percent": float(entry.gain_change[index]),
                "gain_beyond_2_std": bool(entry.gain_beyond[index]),
                "offset": float(one.parameters.offset[index]),
                "offset_std": _known(entry.offset_std[index]),
                "offset_change": float(entry.offset_change[index]),
                "offset_beyond_2_std": bool(entry.offset_beyond[index]),
            }
            for index, name in enumerate(one.channels)
        ],
    }


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
