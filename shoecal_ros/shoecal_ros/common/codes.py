"""What a program knows a state by, and what is wrong with it, for a program and a person."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from shoecal_core.errors import ShoecalError, error_code


class Code(StrEnum):
    """Go with the messages of diagnostics, one for each thing that may be wrong.

    Where an error is reported, its `error_code` is used instead. Meanings and cures are in
    docs/reference/diagnostics.md.
    """

    OK = "ok"
    ENDED = "ended"

    QOS_MISFIT = "qos-misfit"
    TYPE_MISFIT = "type-misfit"
    SECOND_SENDER = "second-sender"
    SEVERAL_SENDERS = "several-senders"
    NODE_SILENT = "node-silent"

    PORT_NOT_OPEN = "port-not-open"
    PORT_LOST = "port-lost"
    PORT_CLOSED = "port-closed"
    PORT_SILENT = "port-silent"
    PORT_UNREADABLE = "port-unreadable"
    FIRMWARE_VERSION = "firmware-version"
    CHANNEL_WITHOUT_CELL = "channel-without-cell"
    CELL_WITHOUT_CHANNEL = "cell-without-channel"
    CLOCK_STANDS = "clock-stands"
    RAW_LOG_ENDED = "raw-log-ended"
    REPLAY_ENDED = "replay-ended"
    SECOND_DRIVER = "second-driver"

    UNREADABLE_MESSAGE = "unreadable-message"
    NO_JOINTS = "no-joints"
    JOINTS_STALE = "joints-stale"
    JOINTS_CONTRADICT = "joints-contradict"
    CLOCKS_APART = "clocks-apart"
    NO_VOLTAGES = "no-voltages"
    VOLTAGES_STALE = "voltages-stale"
    CELL_NOT_SENT = "cell-not-sent"
    CELL_SATURATED = "cell-saturated"
    CELL_SILENT = "cell-silent"
    CELL_STUCK = "cell-stuck"
    CELL_LEAPS = "cell-leaps"
    CELL_FAULT = "cell-fault"

    UNCALIBRATED = "uncalibrated"
    CALIBRATION_WARNED = "calibration-warned"
    TEMPERATURE_GAP = "temperature-gap"
    SELF_CALIBRATION_ENDED = "self-calibration-ended"
    DIAGNOSIS_ENDED = "diagnosis-ended"
    DRIFTED = "drifted"
    UNCONFIRMED = "unconfirmed"
    DISAGREES = "disagrees"
    CONTRADICTED = "contradicted"

    NOBODY_LISTENS = "nobody-listens"
    IMU_STALE = "imu-stale"
    IMU_CONTRADICTS = "imu-contradicts"
    SHOES_STALE = "shoes-stale"
    MOTOR_HOT = "motor-hot"
    HEAT_STALE = "heat-stale"
    SECOND_STEPPER = "second-stepper"

    TRAJECTORY_REFUSED = "trajectory-refused"
    CONTROLLER_REFUSED = "controller-refused"
    CONTROLLER_GAVE_UP = "controller-gave-up"
    CONTROLLER_GOES_ON = "controller-goes-on"
    DRIVER_MISSING = "driver-missing"
    ROBOT_FALLEN = "robot-fallen"
    LISTENER_HANGS = "listener-hangs"


_KEBAB = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


@dataclass(frozen=True)
class Problem:
    """Something that is wrong.

    Attributes:
        code: for a program: a Code, or the `error_code` of an error.
        message: for a person, in one line, with the cure.
        values: figures that go with it.
    """

    code: str
    message: str
    values: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not _KEBAB.fullmatch(self.code) or self.code == Code.OK:
            raise ValueError(f"'{self.code}' is no code of a problem")

    def __str__(self) -> str:
        return self.message

    @classmethod
    def of(cls, error: ShoecalError) -> Problem:
        """What an error says."""
        return cls(error_code(type(error)), str(error))


def joined(problems: Iterable[Problem]) -> Problem | None:
    """Several as one, by the code of the first; None where there is none."""
    reported = list(problems)
    return Problem(reported[0].code, "; ".join(map(str, reported))) if reported else None
