"""Why an action or a service did not do what it was asked, with the code of its answer."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from shoecal_core.errors import ShoecalError
from shoecal_ros.common.health import Level


class RefusedError(ShoecalError):
    """Ends what was asked for.

    Attributes:
        code: constant of the action's result or the service's response.
    """

    def __init__(self, code: int, message: str) -> None:
        self.code = code
        super().__init__(message)


@contextmanager
def faults_refused(
    log: Callable[[Level, str], None], code: int, foreseen: type[ShoecalError] = RefusedError
) -> Iterator[None]:
    """Whatever else goes wrong ends as a refusal, too: who asked is answered, the node lives on.

    Args:
        log: of the node; gets the traceback.
        code: of the answer.
        foreseen: what is passed on as it is.

    Raises:
        RefusedError: with the code, for everything unforeseen.
    """
    try:
        yield
    except foreseen:
        raise
    except Exception as error:
        log(Level.ERROR, traceback.format_exc())
        reported = f"ended by a fault: {worded(error)}; see the node's log, and report it"
        raise RefusedError(code, reported) from error


def worded(error: BaseException) -> str:
    """An error for a person; an unforeseen one with its kind."""
    reported = str(error)
    if isinstance(error, ShoecalError):
        return reported
    return f"{type(error).__name__}: {reported}" if reported else type(error).__name__
