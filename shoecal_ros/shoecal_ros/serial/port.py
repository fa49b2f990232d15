"""Opening a serial port, with errors that name the cure."""

from __future__ import annotations

import errno
import termios
from contextlib import suppress

import serial
from serial.tools.list_ports import comports

from shoecal_ros.serial.errors import (
    PortBusyError,
    PortError,
    PortMissingError,
    PortPermissionError,
)

PORT_TROUBLE = (serial.SerialException, OSError, termios.error)
"""Whatever pyserial lets through when a device goes away."""

WRITE_TIMEOUT_S = 0.1


def open_port(name: str, baud: int) -> serial.Serial:
    """Open a port for this process alone; reads from it do not wait.

    Raises:
        PortMissingError, PortPermissionError, PortBusyError: as they say.
        PortError: for anything that is no serial port, or a rate that it cannot do.
    """
    try:
        port = serial.Serial(name, baud, timeout=0, write_timeout=WRITE_TIMEOUT_S, exclusive=True)
    except PORT_TROUBLE as error:
        raise _port_error(name, error) from error
    except ValueError as error:
        raise PortError(name, f"cannot do {baud} baud; correct 'baud'") from error
    # FTDI adapters otherwise hold bytes back for up to 16 ms; most others lack this switch.
    with suppress(ValueError, NotImplementedError, OSError):
        port.set_low_latency_mode(True)
    return port


def _port_error(name: str, error: Exception) -> PortError:
    number = getattr(error, "errno", None)
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        return PortMissingError(name, sorted(port.device for port in comports()))
    if number in (errno.EACCES, errno.EPERM):
        return PortPermissionError(name)
    if number in (errno.EBUSY, errno.EWOULDBLOCK):
        return PortBusyError(name)
    return PortError(name, f"cannot be opened as a serial port ({error}); correct 'port'")
