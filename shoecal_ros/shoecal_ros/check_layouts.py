"""`ros2 run shoecal_ros check_layouts FILE…`: do viewers' layouts fit the topics there are?"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import rclpy

from shoecal_core.errors import ShoecalError
from shoecal_ros.viewers.fit import misfits


def main(argv: Sequence[str] | None = None) -> int:
    """Print what does not fit; the exit code is 0 where all does."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("layouts", type=Path, nargs="+", metavar="FILE", help=".rviz, .json, .xml")
    parser.add_argument("--wait", type=float, default=3.0, help="s to look for topics")
    args = parser.parse_args(argv)
    rclpy.init()
    node = rclpy.create_node("check_layouts")
    try:
        end = time.monotonic() + args.wait
        while True:
            topics = {
                name: tuple(kinds)
                for name, kinds in node.get_topic_names_and_types()
                if node.count_publishers(name)
            }
            found = [line for file in args.layouts for line in misfits(file, topics)]
            if not found or time.monotonic() > end:
                break
            rclpy.spin_once(node, timeout_sec=0.2)
    except ShoecalError as error:
        print(f"check_layouts: {error}", file=sys.stderr)
        return 1
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    for line in found:
        print(line, file=sys.stderr)
    if not found:
        print(f"{len(args.layouts)} layout(s) fit the topics there are")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
