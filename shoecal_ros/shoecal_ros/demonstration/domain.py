"""A ROS domain that is not in use on this machine, so that no other robot hears a demo."""

from __future__ import annotations

import socket

from shoecal_core.errors import ShoecalError

DOMAINS = range(1, 102)
"""Domain ids whose ports lie below the ephemeral range of Linux."""
FIRST_PORT = 20_000


class NoDomainError(ShoecalError):
    """Every domain is taken."""


def reserve_domain() -> tuple[int, socket.socket]:
    """A domain id, and the token that keeps it: a bound socket, to be closed at the end.

    Raises:
        NoDomainError: when all are taken.
    """
    for domain in DOMAINS:
        token = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            token.bind(("127.0.0.1", FIRST_PORT + domain))
        except OSError:
            token.close()
        else:
            return domain, token
    raise NoDomainError("every ROS domain id is in use; end other demos and tests")
