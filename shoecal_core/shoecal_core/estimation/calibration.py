"""A calibration as a value, and as a file."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError, ShapeError, ShoecalError
from shoecal_core.files import Fields, read_yaml, write_yaml
from shoecal_core.screening.verdict import VERDICTS
from shoecal_core.shoe.correction import POLYNOMIAL, CopCorrection
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters

FORMAT = 3
"""1: without columns, 2: without their errors and those of supports; the oldest that holds all is
written, so that older versions read it."""

EPOCH_NS = 946_684_800 * 10**9
"""Start of the year 2000 [ns]: earlier stamps are of a simulated clock and name no day."""


class CalibrationFileError(FileError):
    """A calibration file whose numbers make no calibration."""


class WrongShoeError(ShoecalError):
    """A calibration of another shoe."""


@dataclass(frozen=True)
class Calibration:
    """Everything needed to turn readings into GRF and CoP, whole or not at all.

    Attributes:
        id: unique name.
        source: self, manual, identity, rezero or set.
        made_ns: when [ns since the epoch].
        robot, shoe: names.
        robot_hash, shoe_hash: SHA-256 of their files.
        channels: n names.
        parameters: gains and offsets.
        covariance: (2n, 2n) of [gain, offset], or None where unknown.
        corrections: of the feet that have one.
        weight: of robot and shoes [N].
        time_offset: joints are late by this much against the readings [s].
        temperature: at calibration [degC], NaN where unknown.
        verdict: PASS, WARN or FAIL.
        reasons: what the verdict rests on.
        fitted_runs: SHA-256 of the run files it was fitted to; empty where they are not known.
        columns: (n, 3) what one unit of each output adds to its foot's wrench, where that was
            calibrated, too (places of cells, crosstalk, plates); None: as the shoe's file says.
        column_covariance: (3n, 5n) of the columns' errors, channel by channel, with those of gains,
            offsets and columns; None: the columns count as exact.
        support_covariance: (3, 3) mean square errors of the right foot's dx, dy, dtheta as the
            joints tell them [m, m, rad]; None: as the tolerances say.
    """

    id: str
    source: str
    made_ns: int
    robot: str
    shoe: str
    robot_hash: str
    shoe_hash: str
    channels: tuple[str, ...]
    parameters: ChannelParameters
    covariance: FloatArray | None
    corrections: tuple[CopCorrection, ...]
    weight: float
    time_offset: float
    temperature: float
    verdict: str
    reasons: tuple[str, ...]
    fitted_runs: tuple[str, ...] = ()
    columns: FloatArray | None = None
    column_covariance: FloatArray | None = None
    support_covariance: FloatArray | None = None

    def __post_init__(self) -> None:
        self._check_channels()
        if self.verdict not in VERDICTS:
            raise ShoecalError(f"verdict '{self.verdict}' is not one of {', '.join(VERDICTS)}")
        if not (np.isfinite(self.weight) and self.weight > 0.0):
            raise ShoecalError(f"weight {self.weight:g} N must be a positive number")
        if not np.isfinite(self.time_offset):
            raise ShoecalError("the time offset must be a finite number")
        if np.isinf(self.temperature):
            raise ShoecalError("the temperature must be a finite number, or NaN where unknown")

    def _check_channels(self) -> None:
        count = len(self.channels)
        if self.parameters.gain.shape != (count,):
            raise ShapeError("gain", f"({count},)", self.parameters.gain.shape)
        if (self.parameters.gain == 0.0).any():
            raise ShoecalError("a gain of zero makes its cell blind; recalibrate")
        if len(set(self.channels)) < count:
            raise ShoecalError("a channel appears twice in the calibration")
        if self.columns is not None:
            if self.columns.shape != (count, 3):
                raise ShapeError("columns", f"({count}, 3)", self.columns.shape)
            if not np.isfinite(self.columns).all():
                raise ShoecalError("the columns hold a number that is not finite")
        self._check_covariances(count)

    def _check_covariances(self, count: int) -> None:
        for name, matrix, shape in (
            ("covariance", self.covariance, (2 * count, 2 * count)),
            ("column covariance", self.column_covariance, (3 * count, 5 * count)),
            ("support covariance", self.support_covariance, (3, 3)),
        ):
            if matrix is None:
                continue
            if matrix.shape != shape:
                raise ShapeError(name, str(shape), matrix.shape)
            if not np.isfinite(matrix).all():
                raise ShoecalError(f"the {name} holds a number that is not finite")
        if self.covariance is None and self.column_covariance is not None:
            raise ShoecalError("errors of columns need the covariance of gains and offsets")

    @property
    def moment(self) -> datetime | None:
        """When it was made, UTC; None where its clock names no day, as a simulated one."""
        if self.made_ns < EPOCH_NS:
            return None
        return datetime.fromtimestamp(self.made_ns // 10**9, UTC)

    @property
    def gain_std(self) -> FloatArray | None:
        """(n,) standard deviations of the gains; None where they are not known."""
        if self.covariance is None:
            return None
        std: FloatArray = np.sqrt(np.diag(self.covariance)[: len(self.channels)])
        return std

    @property
    def offset_std(self) -> FloatArray | None:
        """(n,) standard deviations of the offsets [N or N m]; None where they are not known."""
        if self.covariance is None:
            return None
        std: FloatArray = np.sqrt(np.diag(self.covariance)[len(self.channels) :])
        return std

    @property
    def joint_covariance(self) -> FloatArray | None:
        """(5n, 5n) of the errors of gains, offsets and columns; None where it is not known."""
        if self.covariance is None:
            return None
        own, count = len(self.covariance), len(self.channels)
        whole = np.zeros((5 * count, 5 * count))
        whole[:own, :own] = self.covariance
        if self.column_covariance is not None:
            whole[own:] = self.column_covariance
            whole[:own, own:] = self.column_covariance[:, :own].T
        return whole

    def calibrated(self, shoe: Shoe) -> Shoe:
        """The shoe with the columns that were calibrated.

        Args:
            shoe: as its file says, with this calibration's channels.
        """
        return shoe if self.columns is None else shoe.with_columns(self.columns)

    def sensing(self, shoe: Shoe) -> Sensing:
        """The measuring side under this calibration.

        Raises:
            WrongShoeError: when its channels are not the shoe's.
        """
        if self.channels != shoe.names:
            raise WrongShoeError(
                f"calibration '{self.id}' is of shoe '{self.shoe}' with channels "
                f"{', '.join(self.channels)}, but shoe '{shoe.name}' has {', '.join(shoe.names)}"
            )
        return Sensing(self.calibrated(shoe), self.parameters, self.corrections)


def save_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file, atomically."""
    parameters = calibration.parameters
    write_yaml(
        path,
        {
            "format": _format(calibration),
            "id": calibration.id,
            "source": calibration.source,
            "made_ns": calibration.made_ns,
            "robot": calibration.robot,
            "shoe": calibration.shoe,
            "robot_hash": calibration.robot_hash,
            "shoe_hash": calibration.shoe_hash,
            "weight_n": float(calibration.weight),
            "time_offset_s": float(calibration.time_offset),
            "temperature_degc": (
                None if np.isnan(calibration.temperature) else float(calibration.temperature)
            ),
            "reasons": list(calibration.reasons),
            "fitted_runs": list(calibration.fitted_runs),
            "channels": [
                {"name": name, "gain": float(gain), "offset_n": float(offset)}
                for name, gain, offset in zip(
                    calibration.channels, parameters.gain, parameters.offset, strict=True
                )
            ],
            **({} if calibration.columns is None else {"columns": calibration.columns.tolist()}),
            "corrections": [
                {
                    "foot": FEET[correction.foot],
                    "x": correction.x.tolist(),
                    "y": correction.y.tolist(),
                    "cop_range_m": correction.cop_range.tolist(),
                    "output_range_n": correction.output_range.tolist(),
                }
                for correction in calibration.corrections
            ],
            "covariance": (
                None if calibration.covariance is None else calibration.covariance.tolist()
            ),
            **{
                name: matrix.tolist()
                for name, matrix in (
                    ("column_covariance", calibration.column_covariance),
                    ("support_covariance", calibration.support_covariance),
                )
                if matrix is not None
            },
            # Last, and neither a list nor optional: a file without its end is not taken for whole.
            "verdict": calibration.verdict,
        },
    )


def _format(calibration: Calibration) -> int:
    if calibration.column_covariance is not None or calibration.support_covariance is not None:
        return FORMAT
    return 1 if calibration.columns is None else 2


def load_calibration(path: Path) -> Calibration:
    """Read a calibration file.

    Raises:
        FieldError: for a field that is missing, mistyped or out of bounds.
        CalibrationFileError: for numbers that make no calibration together.
        FileError: as `read_yaml`.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(
        "format", "id", "source", "made_ns", "robot", "shoe", "robot_hash", "shoe_hash",
        "weight_n", "time_offset_s", "temperature_degc", "reasons", "fitted_runs",
        "channels", "columns", "corrections", "covariance", "column_covariance",
        "support_covariance", "verdict",
    )  # fmt: skip
    channels = fields.items("channels")
    for channel in channels:
        channel.only("name", "gain", "offset_n")
    if not channels:
        raise fields.error("channels", "is empty; a calibration needs its channels")
    count = len(channels)
    try:
        return Calibration(
            id=fields.text("id"),
            source=fields.text("source"),
            made_ns=fields.integer("made_ns", minimum=0),
            robot=fields.text("robot"),
            shoe=fields.text("shoe"),
            robot_hash=fields.text("robot_hash"),
            shoe_hash=fields.text("shoe_hash"),
            channels=tuple(channel.text("name") for channel in channels),
            parameters=ChannelParameters(
                np.array([channel.number("gain") for channel in channels]),
                np.array([channel.number("offset_n") for channel in channels]),
            ),
            covariance=(
                fields.array("covariance", (2 * count, 2 * count))
                if "covariance" in fields
                else None
            ),
            corrections=tuple(_correction(item) for item in fields.items("corrections")),
            weight=fields.number("weight_n", above=0.0),
            time_offset=fields.number("time_offset_s"),
            temperature=fields.number("temperature_degc", float("nan")),
            verdict=fields.choice("verdict", dict.fromkeys(VERDICTS)),
            reasons=tuple(fields.texts("reasons")),
            fitted_runs=tuple(fields.texts("fitted_runs") if "fitted_runs" in fields else ()),
            columns=fields.array("columns", (count, 3)) if "columns" in fields else None,
            column_covariance=(
                fields.array("column_covariance", (3 * count, 5 * count))
                if "column_covariance" in fields
                else None
            ),
            support_covariance=(
                fields.array("support_covariance", (3, 3))
                if "support_covariance" in fields
                else None
            ),
        )
    except FileError:
        raise
    except ShoecalError as error:
        raise CalibrationFileError(path, str(error)) from error


def _correction(fields: Fields) -> CopCorrection:
    fields.only("foot", "x", "y", "cop_range_m", "output_range_n")
    x = fields.array("x", (None,))
    width = len(x)
    if width <= POLYNOMIAL:
        raise fields.error("x", f"needs {POLYNOMIAL} numbers and one a channel")
    return CopCorrection(
        foot=FEET.index(fields.choice("foot", dict.fromkeys(FEET))),
        x=x,
        y=fields.array("y", (width,)),
        cop_range=fields.array("cop_range_m", (2, 2)),
        output_range=fields.array("output_range_n", (2, width - POLYNOMIAL)),
    )
