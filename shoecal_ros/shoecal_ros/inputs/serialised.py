"""Messages in their bytes: what can be read of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from shoecal_core.errors import ShoecalError, one_line
from shoecal_ros.common.codes import Code, Problem

T = TypeVar("T")


def understood(
    serialised: Iterable[bytes], read: Callable[[bytes], T], refuse: Callable[[Problem], None]
) -> tuple[list[bytes], list[T]]:
    """Messages that can be read, as they came and as they were read.

    Any peer can send what no program makes: that must neither end a node nor spoil a recording.

    Args:
        serialised: messages.
        read: one of them.
        refuse: called with the reason, for each of the others.
    """
    whole: list[bytes] = []
    found: list[T] = []
    for one in serialised:
        try:
            found.append(read(one))
        except ShoecalError as error:
            refuse(Problem.of(error))
            continue
        except RuntimeError as error:  # rclpy's, of several lines
            reported = f"{one_line(str(error).splitlines()[0])}; update what sends the message"
            refuse(Problem(Code.UNREADABLE_MESSAGE, reported))
            continue
        whole.append(one)
    return whole, found
