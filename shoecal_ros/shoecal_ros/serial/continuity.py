"""Are frames missing, and has the device started again?"""

from __future__ import annotations

from shoecal_ros.serial.clock import TINY_BACK_NS
from shoecal_ros.serial.frame import SEQUENCE_MODULUS, FaultKind, Frame, FrameFault

TINY_BACK_US = TINY_BACK_NS // 1000


class Continuity:
    """Follows sequence and device time of the frames of one device."""

    def __init__(self, *, numbered: bool = True) -> None:
        """Numbered: whether the device gives the sequence; made up, it shows no loss."""
        self._numbered = numbered
        self._last: Frame | None = None

    def check(self, frame: Frame) -> list[FrameFault]:
        """What is wrong between the frame before and this one, if anything.

        A device time or a sequence that goes back means a restart, but for a time that goes back
        by next to nothing in the very next frame: clocks are read at slightly other moments. The
        sequence may wrap around, so it goes back when it is nearer behind than ahead, modulo 2^32.
        A device that restarts counts from 0, so its sequence shows how many frames were lost since.
        """
        last, self._last = self._last, frame
        if last is None:
            return []
        step = (frame.sequence - last.sequence) % SEQUENCE_MODULUS
        now, before = frame.device_time_us, last.device_time_us
        slack = TINY_BACK_US if step == 1 else 0
        time_back = now is not None and before is not None and now < before - slack
        if time_back or step >= SEQUENCE_MODULUS // 2:
            numbered = self._numbered and frame.sequence < SEQUENCE_MODULUS // 2
            return [_restart(last, frame), *_lost(frame.sequence if numbered else 0, frame)]
        if step == 0:
            return [
                FrameFault(
                    FaultKind.REPEATED_SEQUENCE,
                    f"sequence {frame.sequence} came twice; the firmware must count every frame",
                )
            ]
        return _lost(step - 1, frame)


def _restart(last: Frame, frame: Frame) -> FrameFault:
    return FrameFault(
        FaultKind.RESTART,
        f"device restarted: sequence {last.sequence} -> {frame.sequence}, "
        f"time {last.device_time_us} -> {frame.device_time_us} us",
    )


def _lost(count: int, frame: Frame) -> list[FrameFault]:
    if not count:
        return []
    text = f"{count} frames lost before {frame.sequence}"
    return [FrameFault(FaultKind.LOST_FRAMES, text, count)]
