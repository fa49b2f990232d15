"""What is left of a run whose recording was cut short."""

from __future__ import annotations

import numpy as np

from reliability import originals
from reliability.tries import BrokenError
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.recover import recover, recovered_path
from shoecal_core.recording.session import Session


def recovered_samples(session: Session) -> int:
    """Recover the run of a session; how many samples it holds, 0 where nothing can be rescued.

    Raises:
        ShoecalError: when a file cannot be read any more.
        BrokenError: when samples within the run are lost, or differ from those of `originals`.
    """
    for path in session.unfinished:
        try:
            recover(path, recovered_path(path))
        except ShoecalError as error:
            if "rescued" not in str(error):
                raise
    if not session.runs:
        return 0
    readings = session.read(session.runs[-1].run).readings
    numbers = np.arange(len(readings.sequence))
    if not np.array_equal(readings.sequence[:, 0], numbers):
        raise BrokenError("samples within the recovered run are lost")
    if not np.array_equal(readings.value, [originals.volts(number) for number in numbers.tolist()]):
        raise BrokenError("the recovered run holds other readings than were recorded")
    return len(numbers)
