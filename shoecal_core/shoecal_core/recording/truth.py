"""The simulated truth of a run, kept apart from what a real robot would have recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.container import read_container
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.join import Piece
from shoecal_core.recording.messages import series
from shoecal_core.recording.reader import seconds
from shoecal_core.recording.source import RecordedSource
from shoecal_core.recording.writer import RunWriter

# Both feet, left, right: topics and the frame each is in.
_COPS = (schemas.TRUTH_COP, *schemas.TRUTH_FOOT_COP)
_GRFS = (schemas.TRUTH_GRF, *schemas.TRUTH_FOOT_GRF)
_FRAMES = ("l_sole", "l_sole", "r_sole")
_COLUMNS = tuple(f"{topic} {axis}" for topic in _COPS for axis in "xy") + schemas.TRUTH_FOOT_GRF


@dataclass(frozen=True)
class Truth:
    """What the floor really did, at each sampling time.

    Attributes:
        start_ns: stamp that `time` counts from.
        time: (T,) [s].
        cop: (T, 2) of both feet, on the floor plane in l_sole [m]; NaN when unloaded.
        foot_cop: (T, 2, 2) of left and right, each in its own sole frame [m]; NaN likewise.
        foot_grf: (T, 2) vertical force on left and right, positive up [N].
    """

    start_ns: int
    time: FloatArray
    cop: FloatArray
    foot_cop: FloatArray
    foot_grf: FloatArray

    def __post_init__(self) -> None:
        count = len(self.time)
        shapes = {"cop": (count, 2), "foot_cop": (count, 2, 2), "foot_grf": (count, 2)}
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ShapeError(f"truth.{name}", str(shape), found)

    @property
    def grf(self) -> FloatArray:
        """(T,) vertical force on both feet [N]."""
        return np.asarray(self.foot_grf.sum(axis=1))


class TruthWriter:
    """Writes `truth/run_NNN.mcap`; closes, fails and stays unfinished as a RunWriter does."""

    def __init__(self, path: Path, info: RunInfo) -> None:
        self._writer = RunWriter(path, info, topics=schemas.TRUTH_TOPICS, live=False)

    def write(
        self, stamp_ns: int, cop: ArrayLike, foot_cop: ArrayLike, foot_grf: ArrayLike
    ) -> None:
        """Append one sampling time; arguments as `write_all`, without its first dimension."""
        rows = (np.asarray(part, dtype=np.float64)[None] for part in (cop, foot_cop, foot_grf))
        self.write_all(np.array([stamp_ns], dtype=np.int64), *rows)

    def write_all(
        self,
        stamps_ns: IntArray,
        cop: FloatArray,
        foot_cop: FloatArray,
        foot_grf: FloatArray,
    ) -> None:
        """Append T sampling times.

        Args:
            stamps_ns: (T,) when.
            cop: (T, 2) of both feet in l_sole [m]; NaN: nothing is loaded.
            foot_cop: (T, 2, 2) of left and right, each in its own sole frame [m]; NaN likewise.
            foot_grf: (T, 2) of left and right [N].
        """
        count = len(stamps_ns)
        _check("cop", cop, (count, 2))
        _check("foot_cop", foot_cop, (count, 2, 2))
        _check("foot_grf", foot_grf, (count, 2))
        places = (cop, foot_cop[:, 0], foot_cop[:, 1])
        forces = (foot_grf.sum(axis=1), foot_grf[:, 0], foot_grf[:, 1])
        written: list[tuple[int, str, bytes]] = []
        for place, force, frame, on, of in zip(places, forces, _FRAMES, _COPS, _GRFS, strict=True):
            loaded = np.isfinite(place.sum(axis=1))
            made = series(_point(frame), stamps_ns[loaded], place[loaded])
            written += zip(stamps_ns[loaded].tolist(), [on] * len(made), made, strict=True)
            known = np.where(loaded[:, None], place, 0.0)
            wrenches = np.column_stack((force, known[:, 1] * force, -known[:, 0] * force))
            made = series(_wrench(frame), stamps_ns, wrenches)
            written += zip(stamps_ns.tolist(), [of] * count, made, strict=True)
        written.sort(key=lambda message: message[0])
        for stamp, topic, message in written:
            self._writer.write(topic, message, stamp)

    def close(self) -> Path:
        """Finish the file and give it its name."""
        return self._writer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._writer.__exit__(kind, error, trace)


def read_truth(path: Path, start_ns: int | None = None) -> Truth:
    """Read a truth file: for evaluation and benchmarks only, never for a calibration.

    Args:
        path: `truth/run_NNN.mcap`.
        start_ns: stamp that times count from, as a Run's `start_ns`; its own first when None.

    Raises:
        RecordingError: as `read_run`.
    """
    source = RecordedSource(read_container(Path(path), schemas.TRUTH_TOPICS), schemas.TRUTH_TOPICS)
    pieces = []
    for index, topic in enumerate(_COPS):
        block = source.single(topic)
        if block is not None:
            columns = np.array([2 * index, 2 * index + 1])
            pieces.append(Piece(block.stamp_ns, columns, {"": block.group("point.x", "point.y")}))
    for topic in schemas.TRUTH_FOOT_GRF:
        block = source.single(topic)
        if block is None:
            raise source.error(topic, "is missing; simulate the run again")
        columns = np.array([_COLUMNS.index(topic)])
        pieces.append(Piece(block.stamp_ns, columns, {"": block.group("wrench.force.z")}))
    stamps, joined = source.join(schemas.TRUTH_COP, pieces, _COLUMNS, ("",))
    # A file that was cut may end within an instant.
    whole = np.isfinite(joined[""][:, 6:]).all(axis=1)
    if not whole.any():
        raise source.error("", "lacks the force on a foot at all times; simulate the run again")
    stamps, values = stamps[whole], joined[""][whole]
    start = int(stamps[0]) if start_ns is None else start_ns
    return Truth(
        start_ns=start,
        time=seconds(stamps, start),
        cop=values[:, :2],
        foot_cop=values[:, 2:6].reshape(-1, 2, 2),
        foot_grf=values[:, 6:],
    )


def _point(frame: str) -> Callable[[int, FloatArray], bytes]:
    """Makes the message of a CoP (2,)."""
    return lambda stamp, place: messages.point(stamp, frame, (*place, 0.0))


def _wrench(frame: str) -> Callable[[int, FloatArray], bytes]:
    """Makes the message of a vertical force and its moments about x and y (3,)."""
    return lambda stamp, wrench: messages.wrench(
        stamp, frame, (0.0, 0.0, wrench[0]), (wrench[1], wrench[2], 0.0)
    )


def _check(name: str, values: FloatArray, shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ShapeError(f"truth.{name}", str(shape), values.shape)
    if np.isinf(values).any():
        raise ShoecalError(f"truth.{name}: infinite; an unloaded foot is NaN")
