"""The report on a robot's calibrations over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shoecal_core.estimation.history import HistoryEntry, made_text
from shoecal_core.report.figures.tracks import ChannelTrack, tracks
from shoecal_core.report.html import write_page
from shoecal_core.report.page import Group, Page, PageVerdict, Picture, Reason, Section, Table
from shoecal_core.report.quantities import UNKNOWN, quantity
from shoecal_core.shoe.shoe import FEET

DAY_NS = 86_400 * 10**9
DAYS = "days since the first calibration"
MEANING = "Verdict of the latest calibration."
CAPTION = "Bars: one standard deviation, where the file has a covariance."


def history_report(path: Path, history: Sequence[HistoryEntry]) -> None:
    """Write the report as one self-contained HTML file.

    Args:
        path: of the report.
        history: oldest first.

    Raises:
        FileError: when it cannot be written.
    """
    last = history[-1].calibration
    feet = [foot for foot in FEET if any(name.startswith(f"{foot}/") for name in last.channels)]
    reasons = tuple(
        Reason("WARN" if sure else "PASS", text) for sure, text in _changes(history[-1])
    )
    write_page(
        path,
        Page(
            title=f"Calibrations of {last.shoe} on {last.robot}",
            subtitle=f"{len(history)} calibrations, oldest first",
            verdict=PageVerdict(last.verdict, MEANING, reasons),
            key_figures=(),
            sections=(
                Section("Over time", tuple(_foot(history, foot) for foot in feet)),
                Section("Calibrations", (Group(tables=tuple(map(_table, history))),)),
            ),
            provenance=tuple(f"{entry.calibration.id}: {entry.path.name}" for entry in history),
        ),
    )


def _changes(entry: HistoryEntry) -> list[tuple[bool, str]]:
    """Whether channels of the latest have changed for sure, and which."""
    names = np.array(entry.calibration.channels)
    changes = []
    for kind, beyond in (("gains", entry.gain_beyond), ("offsets", entry.offset_beyond)):
        listed = ", ".join(names[beyond]) or "none"
        changes.append((bool(beyond.any()), f"{kind} changed by more than 2 std: {listed}"))
    return changes


def _foot(history: Sequence[HistoryEntry], foot: str) -> Group:
    names = history[0].calibration.channels
    own = [index for index, name in enumerate(names) if name.startswith(f"{foot}/")]
    force = [index for index in own if index in history[0].force_channels]
    first = history[0].calibration
    stamps = [entry.calibration.made_ns - first.made_ns for entry in history]
    days = np.array(stamps, dtype=np.float64) / DAY_NS
    base = first.parameters.gain
    gains = [
        ChannelTrack(
            names[index],
            days,
            np.array([100.0 + entry.gain_change[index] for entry in history]),
            np.array([100.0 * abs(entry.gain_std[index] / base[index]) for entry in history]),
        )
        for index in own
    ]
    offsets = [
        ChannelTrack(
            names[index],
            days,
            np.array([entry.calibration.parameters.offset[index] for entry in history]),
            np.array([entry.offset_std[index] for entry in history]),
        )
        for index in force
    ]
    pictures = [
        Picture("Gains", tracks(gains, DAYS, "gain (% of the first)"), CAPTION),
        Picture("Offsets", tracks(offsets, DAYS, "offset (N)"), CAPTION),
    ]
    return Group(f"{foot.capitalize()} foot", pictures=tuple(pictures))


def _table(entry: HistoryEntry) -> Table:
    one = entry.calibration
    moment = made_text(one, " UTC")
    warm = quantity(one.temperature, "°C", 1) if np.isfinite(one.temperature) else UNKNOWN
    rows = tuple(
        (
            name,
            f"{one.parameters.gain[index]:.5g} ± {entry.gain_std[index]:.2g}",
            f"{entry.gain_change[index]:+.2f} %" + (" *" if entry.gain_beyond[index] else ""),
            f"{one.parameters.offset[index]:.2f} ± {entry.offset_std[index]:.2g}",
            f"{entry.offset_change[index]:+.2f}" + (" *" if entry.offset_beyond[index] else ""),
        )
        for index, name in enumerate(one.channels)
    )
    header = ("", "gain", "change", "offset (N or N m)", "change")
    note = f"{one.verdict}, temperature {warm}. ± one standard deviation; *: beyond 2 of them."
    return Table(f"{moment}, {one.id}", header, rows, note)
