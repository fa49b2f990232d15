"""A ROS 2 node that reads the CoP of both feet, prints it and draws its path.

    .venv/bin/python examples/read_cop.py --out out/examples --count 500 [--ros-args ...]
It ends after so many messages, or with Ctrl-C.
"""

import argparse
import signal
import sys
from pathlib import Path

import rclpy
from geometry_msgs.msg import PointStamped
from matplotlib.figure import Figure
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

WAITING = "nothing on shoe/cop: is a calibration in force, and does the robot stand on its feet?"


class CopReader(Node):
    def __init__(self) -> None:
        super().__init__("cop_reader")
        self.frame = ""
        self.path: list[tuple[float, float]] = []
        self.create_subscription(PointStamped, "shoe/cop", self._take, 10)

    def _take(self, cop: PointStamped) -> None:
        if cop.header.frame_id != self.frame:  # the other foot carries now
            self.frame, self.path = cop.header.frame_id, []
        x, y = 1e3 * cop.point.x, 1e3 * cop.point.y
        self.path.append((x, y))
        self.get_logger().info(f"CoP in {self.frame}: {x:.1f} {y:.1f} mm", throttle_duration_sec=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500, help="messages to read")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    args = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    args.out.mkdir(parents=True, exist_ok=True)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    # Not as an exception, which may come in the midst of taking a message.
    asked_to_end: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: asked_to_end.append(number))
    node = CopReader()
    while len(node.path) < args.count and not asked_to_end:
        rclpy.spin_once(node, timeout_sec=0.5)
        if not node.path:
            node.get_logger().info(WAITING, throttle_duration_sec=5)
    figure = Figure(figsize=(5, 5), layout="constrained")
    axes = figure.add_subplot(title=f"CoP, {node.frame}", xlabel="y (mm)", ylabel="x, forward (mm)")
    axes.plot([y for _, y in node.path], [x for x, _ in node.path], "C1.-")
    axes.axis("equal")
    axes.invert_xaxis()  # the robot looks up the page
    figure.savefig(args.out / "read_cop.png")


if __name__ == "__main__":
    main()
