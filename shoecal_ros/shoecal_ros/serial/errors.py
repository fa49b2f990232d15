"""Errors of the serial side; each names the port or the frame and the cure."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.errors import ShoecalError


class FrameError(ShoecalError):
    """A frame that cannot exist: a field out of its range."""


class ChannelError(ShoecalError):
    """Channels or converters that cannot be."""


class DeviceError(ShoecalError):
    """The simulated device cannot be plugged in."""


class ReplayError(ShoecalError):
    """A log of raw bytes that cannot be replayed."""


class PortError(ShoecalError):
    """A port that cannot be used."""

    def __init__(self, port: str, problem: str) -> None:
        super().__init__(f"serial port {port}: {problem}")


class PortMissingError(PortError):
    """No such port, of those that there are."""

    def __init__(self, port: str, available: Sequence[str]) -> None:
        listed = ", ".join(available) or "none"
        super().__init__(
            port,
            f"does not exist (there are: {listed}); plug the device in or correct 'port', "
            "and see that your user is in the group dialout",
        )


class PortPermissionError(PortError):
    """A port this user may not open."""

    def __init__(self, port: str) -> None:
        super().__init__(
            port,
            "permission denied; run 'sudo usermod -a -G dialout $USER' and log in again",
        )


class PortBusyError(PortError):
    """A port another program holds."""

    def __init__(self, port: str) -> None:
        super().__init__(
            port, "is in use by another program; stop that one (a second driver or a terminal?)"
        )
