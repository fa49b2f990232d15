"""The report on a robot's calibrations over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shoecal_core.estimation.history import HistoryEntry, made_text
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95
from shoecal_core.report.figures.tracks import ChannelTrack, tracks
from shoecal_core.report.html import write_page
from shoecal_core.report.next_step import after_history
from shoecal_core.report.page import Group, Page, PageVerdict, Picture, Reason, Section, Table
from shoecal_core.report.quantities import quantity, uncertain
from shoecal_core.shoe.shoe import FEET

DAY_NS = 86_400 * 10**9
DAYS = "days since the first calibration"
MEANING = "This is the verdict of the latest calibration."
CAPTION = "Bars: 95 % intervals, where the file has a covariance."


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
    changes = _changes(history[-1])
    following = after_history(any(sure for sure, _ in changes))
    reasons = tuple(Reason("WARN" if sure else "PASS", text) for sure, text in changes)
    latest, *others = (_table(entry, first=entry is history[0]) for entry in reversed(history))
    tables = [Group(tables=(latest,))]
    if others:
        title = f"{len(others)} earlier calibration{'s' if len(others) > 1 else ''}"
        tables.append(Group(title, tables=tuple(others), folded=True))
    write_page(
        path,
        Page(
            title=f"Calibrations of {last.shoe} on {last.robot}",
            subtitle=f"{len(history)} calibrations, oldest first",
            verdict=PageVerdict(last.verdict, MEANING, reasons, lines=(following,)),
            key_figures=(),
            sections=(
                Section("Over time", tuple(_foot(history, foot) for foot in feet)),
                Section("Calibrations", tuple(tables)),
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
        changes.append(
            (bool(beyond.any()), f"{kind} changed by more than 2 standard deviations: {listed}")
        )
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
            100.0
            * NORMAL_95
            * np.array([abs(entry.gain_std[index] / base[index]) for entry in history]),
        )
        for index in own
    ]
    offsets = [
        ChannelTrack(
            names[index],
            days,
            np.array([entry.calibration.parameters.offset[index] for entry in history]),
            NORMAL_95 * np.array([entry.offset_std[index] for entry in history]),
        )
        for index in force
    ]
    pictures = [
        Picture("Gains", tracks(gains, DAYS, "gain (% of the first)"), CAPTION),
        Picture("Offsets", tracks(offsets, DAYS, "offset (N)"), CAPTION),
    ]
    return Group(f"{foot.capitalize()} foot", pictures=tuple(pictures))


def _table(entry: HistoryEntry, *, first: bool) -> Table:
    """Gains and offsets, with their changes against the first; the first has none."""
    one = entry.calibration
    warm = quantity(one.temperature, "°C", 1) if np.isfinite(one.temperature) else "unknown"
    rows = []
    for index, name in enumerate(one.channels):
        gain, offset = one.parameters.gain[index], one.parameters.offset[index]
        row = [
            name,
            uncertain(gain, NORMAL_95 * entry.gain_std[index], "1"),
            f"{entry.gain_change[index]:+.2f} %" + (" *" if entry.gain_beyond[index] else ""),
            uncertain(offset, NORMAL_95 * entry.offset_std[index], "1"),
            f"{entry.offset_change[index]:+.2f}" + (" *" if entry.offset_beyond[index] else ""),
        ]
        rows.append(tuple([row[0], row[1], row[3]] if first else row))
    header = (
        ("", "gain", "offset (N or N m)")
        if first
        else ("", "gain", "gain change", "offset (N or N m)", "offset change")
    )
    note = f"{one.verdict}, temperature {warm}. ± is half of the 95 % interval"
    note += "." if first else "; changes: against the first; *: beyond 2 standard deviations."
    return Table(f"{made_text(one, ' UTC')}, {one.id}", header, tuple(rows), note)
