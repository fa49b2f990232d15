"""A port is opened twice.

While a driver reads a device, a second driver opens its port, in every tenth try another process
does, too. The second one must be refused by an error that says that another program has the port;
the first must go on reading, with no frame lost. Then the first is closed: the second must read by
itself within 2 s. No descriptor may be left over.

Bytes, terminal, processes and times are real; the device is simulated.
"""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import BrokenError
from reliability.serial_line import PERIOD_S, TIMEOUT_S, Line, Reader, descriptors, line_config
from shoecal_ros.serial.driver import ShoeDriver, open_driver
from shoecal_ros.serial.errors import PortBusyError

BACK_S = 2.0
ELSEWHERE = 0.1
"""Share of the tries in which another process opens the port."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One second opening a try."""
    failed, told, longest = 0, "", 0.0
    held = 0
    for index in range(first, first + count):
        try:
            back_s = _try(random.Random(seed * 2**40 + index))
            longest = max(longest, back_s)
            if back_s > BACK_S:
                raise BrokenError(f"{back_s:.1f} s until the second reads")
            if held and descriptors() > held:
                raise BrokenError(f"{descriptors()} descriptors are open, {held} before")
        except BrokenError as error:
            failed, told = failed + 1, told or f"try {index}: {error}"
        held = held or descriptors()
        progress(index - first + 1)
    return Result(count, failed, told or f"{longest:.2f} s until the second reads", longest)


def _try(rng: random.Random) -> float:
    """Open it twice, then let the second one have it; seconds until that reads."""
    with Line() as line:
        line.until_read()
        line.sample(rng.randint(1, 10))
        second = open_driver(line_config(line.port), time.time_ns)
        _refused(second)
        if rng.random() < ELSEWHERE:
            _refused_elsewhere(line.port)
        line.sample(rng.randint(1, 10))
        line.settle()
        sequences = [one.sequence for one in line.reader.readings]
        if sequences != list(range(sequences[0], line.sequence)):
            raise BrokenError("the first one lost frames")
        return _taken_over(line, Reader(second))


def _refused(second: ShoeDriver) -> None:
    try:
        second.open()
    except PortBusyError as error:
        if "in use by another program" not in str(error):
            raise BrokenError(f"it was refused by '{error}'") from error
    else:
        raise BrokenError("the port was opened twice")


def _refused_elsewhere(port: Path) -> None:
    program = (
        "import sys; from shoecal_ros.serial.port import open_port; open_port(sys.argv[1], 9600)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(port)], capture_output=True, text=True, check=False
    )
    if "PortBusyError" not in done.stderr:
        raise BrokenError(f"another process opened the port, too {done.stderr[-200:]}")


def _taken_over(line: Line, second: Reader) -> float:
    try:
        if not second.wait(
            lambda: "another program" in str(second.driver.status().problem), TIMEOUT_S
        ):
            raise BrokenError("the second one does not tell why it does not read")
        line.reader.close()
        began = time.monotonic()
        while not second.wait(lambda: bool(second.readings), PERIOD_S):
            line.sample()
            if time.monotonic() - began > TIMEOUT_S:
                raise BrokenError("the second one never reads")
        return time.monotonic() - began
    finally:
        second.close()


ROW = Row(
    key="serial-twice",
    fault="port opened twice",
    holds="the second is refused and told why, the first loses nothing, no leaked descriptor",
    tries=1000,
    step=50,
    run=run,
)
