"""One run file's messages as columns in time, with what had to be dropped noted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.columns import Block, decode_columns
from shoecal_core.recording.container import Contents
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.join import OverlapError, Piece, in_order, join


class RecordedSource:
    """Messages of one file, decoded topic by topic.

    Attributes:
        contents: of the file.
        notes: what was dropped, for a person to read.
    """

    def __init__(self, contents: Contents, topics: Mapping[str, str]) -> None:
        self.contents = contents
        self.notes: list[str] = []
        self._topics = topics

    def blocks(self, topic: str) -> list[Block]:
        """Messages of a topic by layout, stamps increasing within each; empty: none recorded.

        Messages whose stamp repeats or goes back are dropped and noted.

        Raises:
            RecordingError: for bytes that are no such messages, and messages without stamps.
        """
        messages = self.contents.messages.get(topic, [])
        try:
            blocks = decode_columns(self._topics[topic], messages)
        except ShoecalError as error:
            raise self.error(topic, f"{error}; correct its sender") from error
        kept = [block.take(in_order(block.stamp_ns)) for block in blocks]
        dropped = len(messages) - sum(len(block.index) for block in kept)
        if dropped and not any(block.stamp_ns.any() for block in kept):
            raise self.error(topic, "its messages carry no stamp; correct its sender")
        if dropped:
            self.notes.append(
                f"{topic}: {dropped} of {len(messages)} messages dropped, "
                "their stamps repeat or go back"
            )
        return kept

    def single(self, topic: str) -> Block | None:
        """Messages of a topic that may have one sender only; None: none recorded.

        Raises:
            RecordingError: for several senders, and as `blocks`.
        """
        blocks = self.blocks(topic)
        if len(blocks) > 1:
            frames = ", ".join(f"'{block.frame_id}'" for block in blocks)
            raise self.error(topic, f"is sent for several frames ({frames}); record one of them")
        return blocks[0] if blocks else None

    def join(
        self, topic: str, pieces: Sequence[Piece], names: Sequence[str], quantities: Sequence[str]
    ) -> tuple[IntArray, dict[str, FloatArray]]:
        """Stamps (T,) [ns] and quantities (T, n) of n names, as `join.join`.

        Raises:
            RecordingError: for a name that is recorded twice at one time.
        """
        try:
            return join(pieces, len(names), quantities)
        except OverlapError as error:
            raise self.error(
                topic,
                f"'{names[error.column]}' is recorded twice at {error.stamp_ns} ns; "
                "record it from one source",
            ) from error

    def columns(self, topic: str, found: Sequence[str], names: Sequence[str]) -> IntArray:
        """(k,) indices of a message's k names among all names.

        Raises:
            RecordingError: for an unknown name or one that is twice in a message.
        """
        place = {name: index for index, name in enumerate(names)}
        for name in found:
            if name not in place:
                raise self.error(topic, f"names '{name}', known are: {', '.join(names)}")
        if len(set(found)) != len(found):
            raise self.error(topic, f"has a name twice: {', '.join(found)}; correct its sender")
        return np.array([place[name] for name in found], dtype=np.int64)

    def error(self, topic: str, problem: str) -> RecordingError:
        """The error to raise for one topic."""
        return RecordingError(self.contents.path, problem, field=topic)
