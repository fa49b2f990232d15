"""The calibrator node, whose disk makes nothing durable while the file SLOW_DISK is there."""

from __future__ import annotations

import os
import time
from pathlib import Path

from shoecal_ros.nodes.calibrator import main

SLOW_DISK = Path(os.environ["SLOW_DISK"])
WAITING = SLOW_DISK.with_suffix(".waiting")

_fsync = os.fsync


def _slow_fsync(file: int) -> None:
    while SLOW_DISK.exists():
        WAITING.touch()
        time.sleep(0.01)
    _fsync(file)


if __name__ == "__main__":
    os.fsync = _slow_fsync  # type: ignore[assignment]
    main()
