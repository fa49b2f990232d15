"""The SROS2 policy of shoecal's nodes in a namespace, on standard output.

ros2 run shoecal_ros security_policy /lab > lab.policy.xml
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from shoecal_core.errors import ShoecalError, one_line
from shoecal_core.files import read_bytes
from shoecal_core.workspace import config_dir

_ROOT = 'ns="/"'
"""Of every profile in the file; names in it are relative but those of ROS itself."""


class NamespaceError(ShoecalError):
    """A namespace that ROS does not take."""


def policy(namespace: str) -> str:
    """The policy's text for nodes in a namespace, with or without its first slash.

    Raises:
        NamespaceError: for one that ROS does not take.
        FileError: where the policy cannot be read.
    """
    full = f"/{namespace.strip('/')}"
    try:
        validate_namespace(full)
    except InvalidNamespaceException as error:
        reported = f"namespace {namespace}: {one_line(str(error))}"
        raise NamespaceError(f"{reported}; correct it") from error
    text = read_bytes(config_dir() / "security" / "shoecal.policy.xml").decode()
    return text.replace(_ROOT, f'ns="{full}"')


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the policy; 1 where that fails."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("namespace", help="as in the launch files' namespace:=")
    try:
        sys.stdout.write(policy(parser.parse_args(arguments).namespace))
    except ShoecalError as error:
        print(f"security_policy: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
