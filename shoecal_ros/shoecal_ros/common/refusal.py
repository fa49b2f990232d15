"""Why an action was not done, with the code of its result."""

from __future__ import annotations

from shoecal_core.errors import ShoecalError


class RefusedError(ShoecalError):
    """Ends an action.

    Attributes:
        code: constant of the action's result.
    """

    def __init__(self, code: int, message: str) -> None:
        self.code = code
        super().__init__(message)
