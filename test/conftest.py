"""What all tests share: repeatable draws, and ROS 2 traffic that no other process hears."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from pathlib import Path

import pytest
from hypothesis import settings

_DOMAINS = range(1, 102)
"""Domain ids whose ports lie below the ephemeral range of Linux."""
_FIRST_PORT = 20_000
_QUICK_DISCOVERY = Path(__file__).with_name("ros") / "quick_discovery.xml"

settings.register_profile("shoecal", derandomize=True, deadline=None)
settings.load_profile("shoecal")

_reservation = pytest.StashKey[socket.socket]()


def pytest_configure(config: pytest.Config) -> None:
    """Give this process a ROS domain of its own for as long as it lives, and its children ears."""
    # A shell's background jobs ignore interrupts, and so would every program under test.
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # A library that reads lines sets it: what is piped must not depend on who asks.
    os.environ.pop("COLUMNS", None)
    # Hundreds of programs are started, and each would compile all that it imports anew.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    domain, config.stash[_reservation] = _reserve_domain()
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(_QUICK_DISCOVERY)


def pytest_unconfigure(config: pytest.Config) -> None:
    config.stash[_reservation].close()


def _reserve_domain() -> tuple[int, socket.socket]:
    """A domain id that no other test process holds: a bound socket is the token."""
    for domain in _DOMAINS:
        token = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            token.bind(("127.0.0.1", _FIRST_PORT + domain))
        except OSError:
            token.close()
        else:
            return domain, token
    raise pytest.UsageError("every ROS domain id is in use; end other test processes")
