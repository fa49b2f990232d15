"""Raw sensor readings of a run, whatever topic and device they came from."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording import schemas
from shoecal_core.recording.columns import Block
from shoecal_core.recording.join import Piece, at_common_instants, sampled_apart
from shoecal_core.recording.run import Readings
from shoecal_core.recording.source import RecordedSource
from shoecal_core.shoe.shoe import AXES, FEET, Shoe

LEAST_NS = 100_000_000
"""Readings that stay for less may do so by chance [ns]."""
NOISY_STEPS = 4.0
"""Usual change from reading to reading, over the least there is, of a channel that trembles."""
TREMBLING = 2
"""Channels that must tremble: readings of coarse converters stay where they are while nothing
moves."""


def held(stamp_ns: IntArray, values: FloatArray) -> BoolArray:
    """(T,) mask of readings of one source (T, k) that are its last ones sent again."""
    steps = np.abs(np.diff(values, axis=0))
    if not len(steps) or sum(map(_trembles, steps.T)) < min(TREMBLING, values.shape[1]):
        return np.zeros(len(values), dtype=bool)
    same = np.concatenate(([False], (steps == 0.0).all(axis=1)))
    # Each stretch from the reading that is sent again to the last that is the same.
    starts = np.flatnonzero(same & ~np.roll(same, 1)) - 1
    ends = np.flatnonzero(same & ~np.append(same[1:], False))
    for start, end in zip(starts, ends, strict=True):
        if stamp_ns[end] - stamp_ns[start] < LEAST_NS:
            same[start : end + 1] = False
    return same


def _trembles(steps: FloatArray) -> bool:
    """Whether a channel's readings differ by many steps of its converter, as a rule."""
    moved = steps[steps > 0.0]
    return bool(len(moved)) and float(np.median(moved)) >= NOISY_STEPS * float(moved.min())


_QUANTITIES = ("value", "status", "sequence", "temperature")
LARGEST = 1e9
"""No cell reads that much in any unit: its sender has written something else."""
_BACKWARDS_SHARE = 0.1
"""A device restarts now and then; a counter that runs back more often belongs to two devices."""


def read_readings(source: RecordedSource, shoe: Shoe) -> tuple[IntArray, dict[str, FloatArray]]:
    """Readings of every channel, joined by stamp.

    Boards or sensors that sample at instants of their own are brought to common ones, by their
    stamps; a note says so.

    Returns:
        Stamps (T,) [ns], and by quantity (T, n), NaN where none was given.

    Raises:
        RecordingError: no readings, a cell the shoe does not have, two sources of one cell.
    """
    gathered = _Gathered(source, shoe)
    for block in source.blocks(schemas.VOLTAGES):
        gathered.add_voltages(block)
    for foot, topic in zip(FEET, schemas.FORCE_TORQUE, strict=True):
        axes = [axis for axis in AXES if f"{foot}/{axis}" in shoe.names]
        for block in source.blocks(topic) if axes else ():
            gathered.add_wrenches(topic, foot, axes, block)
    if not gathered.pieces:
        wanted = ", ".join((schemas.VOLTAGES, *schemas.FORCE_TORQUE))
        raise source.error("", f"holds no readings of '{shoe.name}' ({wanted}); record them")
    pieces = gathered.pieces
    if sampled_apart(list(gathered.sources.values())):
        pieces = at_common_instants(list(gathered.sources.values()), len(shoe.names), _QUANTITIES)
        source.notes.append(
            f"readings have stamps of their own by source ({'; '.join(gathered.sources)}): "
            "interpolated to common ones"
        )
    return source.join(schemas.VOLTAGES, pieces, shoe.names, _QUANTITIES)


def make_readings(
    source: RecordedSource, shoe: Shoe, time: FloatArray, joined: dict[str, FloatArray]
) -> Readings:
    """Readings from joined quantities; what is missing is noted in `source`.

    Args:
        source: of the run.
        shoe: whose n channels they are of.
        time: (T,) since the run's start [s].
        joined: (T, n) by quantity, as `read_readings` returns them.
    """
    value = np.where(np.abs(joined["value"]) < LARGEST, joined["value"], np.nan)
    missing = np.isnan(value)
    status = np.where(
        missing & (joined["status"] != schemas.FAULT), schemas.NO_DATA, joined["status"]
    )
    never = missing.all(axis=0)
    source.notes += [f"channel '{name}' has no readings" for name in np.array(shoe.names)[never]]
    partial = int(missing[:, ~never].any(axis=1).sum())
    if partial:
        source.notes.append(f"{partial} of {len(time)} readings lack some channels")
    return Readings(
        time=time,
        names=shoe.names,
        value=value,
        status=status.astype(np.uint8),
        sequence=np.nan_to_num(joined["sequence"], nan=-1.0).astype(np.int64),
        temperature=joined["temperature"],
    )


class _Gathered:
    """Pieces of readings by their source; every channel has one source."""

    def __init__(self, source: RecordedSource, shoe: Shoe) -> None:
        self.sources: dict[str, list[Piece]] = {}
        self._source = source
        self._shoe = shoe
        self._origins: dict[str, str] = {}

    @property
    def pieces(self) -> list[Piece]:
        """Of all sources."""
        return [piece for pieces in self.sources.values() for piece in pieces]

    def add_voltages(self, block: Block) -> None:
        """Messages of a driver.

        Raises:
            RecordingError: for values that do not match the cells, and two devices on one topic.
        """
        topic, cells, numbers = schemas.VOLTAGES, block.texts["cell"], block.numbers
        for name in ("voltage", "status"):
            if numbers[name].shape[1] != len(cells):
                raise self._source.error(
                    topic,
                    f"has {numbers[name].shape[1]} values of '{name}' for {len(cells)} cells; "
                    "correct the driver",
                )
        self._check_counter(cells, numbers["sequence"][:, 0])
        shape = (len(block.index), len(cells))
        values = {
            "value": numbers["voltage"],
            "status": numbers["status"],
            "sequence": np.broadcast_to(numbers["sequence"], shape),
            "temperature": np.broadcast_to(numbers["temperature"], shape),
        }
        self._add(topic, cells, block, values)

    def add_wrenches(self, topic: str, foot: str, axes: list[str], block: Block) -> None:
        """Messages of a six-axis sensor, of which the shoe has these axes."""
        value = block.group(*(_WRENCH_FIELD[axis] for axis in axes))
        status = np.full(value.shape, float(schemas.GOOD))
        names = tuple(f"{foot}/{axis}" for axis in axes)
        self._add(topic, names, block, {"value": value, "status": status})

    def _add(
        self, topic: str, names: tuple[str, ...], block: Block, values: dict[str, FloatArray]
    ) -> None:
        origin = f"{topic} with frame '{block.frame_id}'"
        for name in names:
            first = self._origins.setdefault(name, origin)
            if first != origin:
                raise self._source.error(
                    topic, f"'{name}' comes from {first} and from {origin}; give it one source"
                )
        columns = self._source.columns(topic, names, self._shoe.names)
        again = held(block.stamp_ns, values["value"])
        if again.any():
            values = {**values, "value": np.where(again[:, None], np.nan, values["value"])}
            self._source.notes.append(
                f"{origin}: its board sent the same readings again for 0.1 s and more, "
                f"{int(again.sum())} of {len(again)} ({again.mean():.0%}); left out"
            )
        self.sources.setdefault(origin, []).append(Piece(block.stamp_ns, columns, values))

    def _check_counter(self, cells: tuple[str, ...], sequence: FloatArray) -> None:
        steps = np.diff(sequence)
        # The counter has 32 bits: a step back by about all of them is its overflow.
        back = int(np.sum((steps < 0.0) & (steps > -(2.0**31))))
        if back > max(1.0, _BACKWARDS_SHARE * len(steps)):
            raise self._source.error(
                schemas.VOLTAGES,
                f"the device counter runs back {back} times in {len(steps)}: two devices send "
                f"{', '.join(cells)}; give each cell one source",
            )
        if back:
            self._source.notes.append(
                f"{schemas.VOLTAGES}: the device counter ran back {back} times"
            )


_WRENCH_FIELD = {
    axis: f"wrench.{'force' if axis.startswith('f') else 'torque'}.{axis[1]}" for axis in AXES
}
