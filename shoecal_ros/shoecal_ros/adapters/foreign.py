"""Messages of packages that only some robots need."""

from __future__ import annotations

import importlib
from typing import Any

from shoecal_core.errors import ShoecalError


class PackageMissingError(ShoecalError):
    """A package of messages that is not installed."""

    def __init__(self, package: str) -> None:
        debian = package.replace("_", "-")
        super().__init__(
            f"package {package} is not there; sudo apt install ros-jazzy-{debian}, or source the "
            "workspace that holds it"
        )


def foreign(package: str, kind: str, name: str) -> type[Any]:
    """A message or action of another package.

    Args:
        package: for example `naoqi_bridge_msgs`.
        kind: `msg` or `action`.
        name: of the type.

    Raises:
        PackageMissingError: where it is not installed.
    """
    try:
        found: type[Any] = getattr(importlib.import_module(f"{package}.{kind}"), name)
    except ImportError as error:
        raise PackageMissingError(package) from error
    return found
