"""What one device sent at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.arrays import FloatArray


@dataclass(frozen=True)
class VoltageFrame:
    """One device frame.

    Attributes:
        stamp_ns: time of sampling [ns].
        source: who sent it (the message's frame_id).
        sequence: the device's counter.
        cells: k names.
        voltage: (k,) raw, NaN where a cell gave none.
        status: (k,) constants of ShoeVoltages.
        temperature: [degC], NaN where there is no sensor.
    """

    stamp_ns: int
    source: str
    sequence: int
    cells: tuple[str, ...]
    voltage: FloatArray
    status: NDArray[np.uint8]
    temperature: float = math.nan
