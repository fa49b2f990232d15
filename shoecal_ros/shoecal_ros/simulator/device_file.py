"""The driver's file for the simulated device."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.files import write_yaml
from shoecal_core.shoe.shoe import Shoe

ALARM_S = 5.0
"""Simulated data are late on a busy machine, not stale."""


def write_device(path: Path, shoe: Shoe, port: Path, bits: int) -> None:
    """Write the driver's file for the simulated device of a shoe: one channel a cell, in order.

    Args:
        path: of the file.
        shoe: with its converter's range.
        port: of the device.
        bits: of the converter.

    Raises:
        FileError: when it cannot be written.
    """
    converters = [
        {
            "volts_per_count": (channel.highest - channel.lowest) / 2**bits,
            "bits": bits,
            "encoding": "signed",
        }
        for channel in shoe.channels
    ]
    write_yaml(
        path,
        {
            "format": 1,
            "port": str(port),
            "baud": 115200,
            "mode": "binary",
            "alarm_s": ALARM_S,
            "converter": converters[0],
            "channels": [
                {"index": index, "cell": name, "converter": converter}
                for index, (name, converter) in enumerate(zip(shoe.names, converters, strict=True))
            ],
        },
    )
