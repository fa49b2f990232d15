"""A port is opened twice.

While a driver reads a device, a second driver opens its port, in every tenth try another process
does, too. The second one must be refused by an error that says that another program has the port;
the first must go on reading, with no frame lost. Then the first is closed: the second must read by
itself within 2 s. No descriptor may be left over.

Bytes, terminal, processes and times are real; the device is simulated.
"""

from __future__ import annotations

import subprocess
import sys

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_line import Line, check_descriptors, descriptors
from reliability.tries import BrokenError, run_tries
from shoecal_ros.serial.errors import PortBusyError

BACK_S = 2.0
ELSEWHERE = 0.1
"""Share of the tries in which another process opens the port."""
OPEN = "import sys; from shoecal_ros.serial.port import open_port; open_port(sys.argv[1], 9600)"
BUSY = "in use by another program"


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One second opening a try."""
    with Line() as line:
        line.until_read()  # so that all that stays open is open

    held = descriptors()

    def attempt(_: int, rng: np.random.Generator) -> float:
        with Line() as line:
            back_s = _try(line, rng)
        check_descriptors(held)
        return back_s

    return run_tries(attempt, first, count, seed, progress, "{:.2f} s until the second reads")


def _try(line: Line, rng: np.random.Generator) -> float:
    """Open it twice, then let the second one have it; seconds until that reads."""
    line.until_read()
    line.sample(int(rng.integers(1, 11)))
    second = line.another_driver()
    try:
        second.open()
    except PortBusyError as error:
        if BUSY not in str(error):
            raise BrokenError(f"it was refused by '{error}'") from error
    else:
        raise BrokenError("the port was opened twice")
    if rng.random() < ELSEWHERE:
        command = [sys.executable, "-c", OPEN, str(line.port)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if "PortBusyError" not in done.stderr:
            raise BrokenError(f"another process opened the port, too {done.stderr[-200:]}")
    if second.read(0.0) or BUSY not in str(second.status().problem):
        raise BrokenError("the second one does not say why it does not read")
    line.sample(int(rng.integers(1, 11)))
    line.settle()
    sequences = [one.sequence for one in line.readings]
    if sequences != list(range(sequences[0], line.sequence)):
        raise BrokenError("the first one lost frames")
    line.driver.close()
    line.driver = second
    return line.until_read(BACK_S)


ROW = Row(
    key="serial-twice",
    fault="port opened twice",
    holds="the second is refused and told why, the first loses nothing, no leaked descriptor",
    tries=1000,
    step=50,
    run=run,
)
