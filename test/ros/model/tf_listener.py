"""Says which frames come on /tf, each once: parent, child and the child's height in it."""

from __future__ import annotations

import contextlib

import rclpy
from rclpy.node import Node
from tf2_msgs.msg import TFMessage


class Listener(Node):
    """Hears /tf."""

    def __init__(self) -> None:
        super().__init__("tf_listener")
        self._said: set[tuple[str, str]] = set()
        self.create_subscription(TFMessage, "/tf", self._hear, 100)
        print("listening", flush=True)

    def _hear(self, message: TFMessage) -> None:
        for one in message.transforms:
            frames = (one.header.frame_id, one.child_frame_id)
            if frames not in self._said:
                self._said.add(frames)
                print(*frames, f"{one.transform.translation.z:.3f}", flush=True)


if __name__ == "__main__":
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt):
        rclpy.spin(Listener())
