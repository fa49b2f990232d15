"""One robot's calibrations over time: which gains and offsets have changed, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import (
    Calibration,
    CalibrationFileError,
    load_calibration,
)
from shoecal_core.shoe.shoe import AXES

SURE_STDS = 2.0
"""A change beyond this many standard deviations is marked."""
TORQUE_AXES = AXES[3:]
"""Channels of these names have offsets in N m."""


def made_text(calibration: Calibration, zone: str = "") -> str:
    """When it was made; by a simulated clock, how long that had run."""
    if calibration.moment is None:
        return f"simulated, {calibration.made_ns / 1e9:.0f} s"
    return calibration.moment.strftime(f"%Y-%m-%d %H:%M{zone}")


@dataclass(frozen=True)
class HistoryEntry:
    """One calibration, compared with the first of its history; n channels.

    Attributes:
        path: of its file.
        calibration: as loaded.
        gain_std, offset_std: (n,) standard deviations [gain's unit; N or N m], NaN where unknown.
        gain_change: (n,) of the first gain [%].
        gain_change_std: (n,) its standard deviation, both calibrations taken as independent [%].
        offset_change: (n,) [N or N m].
        offset_change_std: (n,) likewise.
    """

    path: Path
    calibration: Calibration
    gain_std: FloatArray
    offset_std: FloatArray
    gain_change: FloatArray
    gain_change_std: FloatArray
    offset_change: FloatArray
    offset_change_std: FloatArray

    @property
    def gain_beyond(self) -> BoolArray:
        """(n,) gains that changed by more than 2 standard deviations."""
        return np.asarray(np.abs(self.gain_change) > SURE_STDS * self.gain_change_std)

    @property
    def offset_beyond(self) -> BoolArray:
        """(n,) offsets that changed by more than 2 standard deviations."""
        return np.asarray(np.abs(self.offset_change) > SURE_STDS * self.offset_change_std)

    @property
    def force_channels(self) -> IntArray:
        """(k,) indices of the channels whose offsets are forces."""
        names = self.calibration.channels
        return np.flatnonzero([name.rpartition("/")[2] not in TORQUE_AXES for name in names])

    def zero_sum(self, foot: str) -> float:
        """Sum of the offsets of a foot's vertical channels [N]."""
        return float(
            sum(
                self.calibration.parameters.offset[index]
                for index in self.force_channels
                if self.calibration.channels[index].startswith(f"{foot}/")
                and self.calibration.channels[index].rpartition("/")[2] not in AXES[:2]
            )
        )


def load_history(paths: Sequence[Path]) -> list[HistoryEntry]:
    """Calibrations of one robot and one shoe, oldest first, each compared with the oldest.

    Raises:
        CalibrationFileError: for one of another robot, shoe or channels, and for one named twice.
        FileError: as `load_calibration`.
    """
    loaded = [(path, load_calibration(path)) for path in paths]
    if not loaded:
        raise ShoecalError("name at least one calibration file")
    loaded.sort(key=lambda one: one[1].made_ns)
    seen: dict[str, Path] = {}
    first_path, first = loaded[0]
    for path, one in loaded:
        for kind, own, other in (
            ("robot", one.robot, first.robot),
            ("shoe", one.shoe, first.shoe),
            ("channels", ", ".join(one.channels), ", ".join(first.channels)),
        ):
            if own != other:
                problem = (
                    f"is '{own}', but '{other}' in {first_path}; name calibrations of one only"
                )
                raise CalibrationFileError(path, problem, field=kind)
        if one.id in seen:
            problem = f"'{one.id}' is also in {seen[one.id]}; name each calibration once"
            raise CalibrationFileError(path, problem, field="id")
        seen[one.id] = path
    return [_compared(path, one, first) for path, one in loaded]


def _compared(path: Path, one: Calibration, first: Calibration) -> HistoryEntry:
    gain_std, offset_std = _stds(one)
    first_gain_std, first_offset_std = _stds(first)
    gain, base = one.parameters.gain, first.parameters.gain
    offset_change = one.parameters.offset - first.parameters.offset
    return HistoryEntry(
        path,
        one,
        gain_std,
        offset_std,
        100.0 * (gain / base - 1.0),
        100.0 * np.hypot(gain_std / base, gain * first_gain_std / base**2),
        offset_change,
        np.hypot(offset_std, first_offset_std),
    )


def _stds(one: Calibration) -> tuple[FloatArray, FloatArray]:
    """Of gains and offsets (n,), NaN where they are not known."""
    unknown = np.full(len(one.channels), np.nan)
    gain, offset = one.gain_std, one.offset_std
    return unknown if gain is None else gain, unknown if offset is None else offset
