"""The firmware of firmware/, built and running, at the other end of a pseudo-terminal."""

from __future__ import annotations

import os
import shutil
import subprocess
import tty
from pathlib import Path
from types import TracebackType
from typing import Self

import pytest

from core.shoe.shoes import ROOT
from shoecal_ros.serial.channel_map import Converter, DeviceChannel
from shoecal_ros.serial.config import DriverConfig, Mode
from shoecal_ros.serial.text_protocol import TextTime

FIRMWARE = ROOT / "firmware"
ONE = Converter(1.0)


def make(build: Path, *words: str) -> Path:
    """Build with the Makefile; the folder that it built in."""
    done = _made(build, *words)
    assert done.returncode == 0, done.stderr
    return build


def refused(build: Path, *words: str) -> str:
    """What the Makefile says where it cannot build."""
    done = _made(build, *words)
    assert done.returncode
    return done.stderr


def _made(build: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["make", "--silent", "-C", FIRMWARE, f"BUILD={build}", *words],
        capture_output=True,
        text=True,
        check=False,
    )


def need_avr() -> None:
    """Skip where this machine cannot build for the board."""
    if shutil.which(os.environ.get("AVR_CC", "avr-gcc")) is None:
        pytest.skip("no avr-gcc here (apt install gcc-avr avr-libc)")


def need_emulator() -> None:
    """Skip where this machine cannot emulate the board."""
    need_avr()
    flags = os.environ.get("EMULATOR_FLAGS", "").split()
    looked = subprocess.run(
        [os.environ.get("CC", "cc"), *flags, "-E", "-"],
        input="#include <simavr/sim_avr.h>\n#include <simavr/sim_elf.h>\n",
        capture_output=True,
        text=True,
        check=False,
    )
    if looked.returncode:
        pytest.skip("no simavr here (apt install libsimavr-dev libelf-dev)")


class Board:
    """A program that is the board; its serial line is `port`."""

    def __init__(self, program: list[Path], *converters: object) -> None:
        """Switch it on.

        Args:
            program: and its first words.
            converters: counts, or `dead` or `short`, of each.
        """
        self._line, self._port = os.openpty()
        tty.setraw(self._port)
        self.port = os.ttyname(self._port)
        words = [*map(str, program), *map(str, converters)]
        self._process = subprocess.Popen(words, stdin=self._line, stdout=self._line)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._line)
        os.close(self._port)

    def config(self, channels: int) -> DriverConfig:
        """A driver's configuration whose volts are counts."""
        return DriverConfig(
            port=self.port,
            baud=115200,
            mode=Mode.BINARY,
            text_time=TextTime.NONE,
            text_columns=channels,
            latency_ns=0,
            alarm_s=0.5,
            raw_log=None,
            channels=tuple(DeviceChannel(k, f"left/{k}", ONE) for k in range(channels)),
        )
