"""Why an action or a service did not do what it was asked, with the code of its answer."""

from __future__ import annotations

from shoecal_core.errors import ShoecalError


class RefusedError(ShoecalError):
    """Ends what was asked for.

    Attributes:
        code: constant of the action's result or the service's response.
    """

    def __init__(self, code: int, message: str) -> None:
        self.code = code
        super().__init__(message)
