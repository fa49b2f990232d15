"""Are frames missing, and has the device started anew?"""

from __future__ import annotations

from shoecal_ros.serial.frame import SEQUENCE_MODULUS, Fault, FaultKind, Frame


class Continuity:
    """Follows sequence and device time of the frames of one device."""

    def __init__(self) -> None:
        self._last: Frame | None = None

    def check(self, frame: Frame) -> Fault | None:
        """What is wrong between the frame before and this one, if anything.

        A device time or a sequence that goes back means a restart; the sequence may wrap
        around, so it goes back when it is nearer behind than ahead, modulo 2^32.
        """
        last, self._last = self._last, frame
        if last is None:
            return None
        step = (frame.sequence - last.sequence) % SEQUENCE_MODULUS
        now, before = frame.device_time_us, last.device_time_us
        time_back = now is not None and before is not None and now < before
        if time_back or step >= SEQUENCE_MODULUS // 2:
            return Fault(
                FaultKind.RESTART,
                f"device restarted: sequence {last.sequence} -> {frame.sequence}, "
                f"time {before} -> {now} us",
            )
        if step == 0:
            return Fault(
                FaultKind.REPEATED_SEQUENCE,
                f"sequence {frame.sequence} came twice; the firmware must count every frame",
            )
        if step > 1:
            return Fault(
                FaultKind.LOST_FRAMES, f"{step - 1} frames lost before {frame.sequence}", step - 1
            )
        return None
