"""Are frames missing, and has the device started anew?"""

from __future__ import annotations

from shoecal_ros.serial.frame import SEQUENCE_MODULUS, Fault, FaultKind, Frame


class Continuity:
    """Follows sequence and device time of the frames of one device."""

    def __init__(self) -> None:
        self._last: Frame | None = None

    def check(self, frame: Frame) -> list[Fault]:
        """What is wrong between the frame before and this one, if anything.

        A device time or a sequence that goes back means a restart; the sequence may wrap
        around, so it goes back when it is nearer behind than ahead, modulo 2^32. A device that
        restarts counts from 0, so a sequence that went back tells how many frames were lost since
        then. One that is ahead although time went back tells the least there can be.
        """
        last, self._last = self._last, frame
        if last is None:
            return []
        step = (frame.sequence - last.sequence) % SEQUENCE_MODULUS
        now, before = frame.device_time_us, last.device_time_us
        time_back = now is not None and before is not None and now < before
        if step >= SEQUENCE_MODULUS // 2 or (step == 0 and time_back):
            lost = frame.sequence if frame.sequence < SEQUENCE_MODULUS // 2 else 0
            return [_restart(last, frame), *_lost(lost, frame)]
        if time_back:
            return [_restart(last, frame), *_lost(step - 1, frame)]
        if step == 0:
            return [
                Fault(
                    FaultKind.REPEATED_SEQUENCE,
                    f"sequence {frame.sequence} came twice; the firmware must count every frame",
                )
            ]
        return _lost(step - 1, frame)


def _restart(last: Frame, frame: Frame) -> Fault:
    return Fault(
        FaultKind.RESTART,
        f"device restarted: sequence {last.sequence} -> {frame.sequence}, "
        f"time {last.device_time_us} -> {frame.device_time_us} us",
    )


def _lost(count: int, frame: Frame) -> list[Fault]:
    if not count:
        return []
    text = f"{count} frames lost before {frame.sequence}"
    return [Fault(FaultKind.LOST_FRAMES, text, count)]
