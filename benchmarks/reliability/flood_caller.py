"""Calls services of the calibrator at a steady rate: a program of its own, for `flood`.

    python flood_caller.py CALLS RATE
    python flood_caller.py --serve

The first prints one line of JSON: for every call how long its answer took [s], -1 where none
came, the same of a service that does nothing (the second form offers it), and how many
self-calibrations were begun. No executor: this must not be what is slow.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import QoSProfile
from shoecal_msgs.srv import GetCalibration, SelfCalibrate
from std_srvs.srv import Trigger

WAIT_S = 5.0
"""For what is not answered when the last call was made."""
MANY = QoSProfile(depth=1000)
BARE, BARE_SHARE = "bare", 20
"""A service that does nothing; called once in so many calls."""
KINDS: tuple[tuple[type[Any], str], ...] = (
    *((SelfCalibrate, "shoe/self_calibrate"),) * 8,
    (GetCalibration, "shoe/get_calibration"),
    (Trigger, "shoe/rollback"),
)


class Caller:
    """One client, and what became of its calls."""

    def __init__(self, node: Node, kind: type[Any], name: str) -> None:
        self.client: Client = node.create_client(kind, name, qos_profile=MANY)
        self.accepted = 0
        self._kind = kind
        self._sent: dict[int, tuple[int, float]] = {}

    def call(self, number: int) -> None:
        """Call; the call has this number."""
        with self.client.handle:
            sequence = self.client.handle.send_request(self._kind.Request())
        self._sent[sequence] = number, time.monotonic()

    def collect(self, took: list[float]) -> None:
        """Note by their number how long the calls took that are answered."""
        while True:
            with self.client.handle:
                header, response = self.client.handle.take_response(self._kind.Response)
            if header is None:
                return
            number, sent = self._sent.pop(header.request_id.sequence_number)
            took[number] = time.monotonic() - sent
            self.accepted += bool(getattr(response, "accepted", False))


def call(node: Node, count: int, rate: float) -> dict[str, object]:
    """Call as often and as quickly as asked for; what came of it."""
    bare = Caller(node, Trigger, BARE)
    callers = {name: Caller(node, kind, name) for kind, name in KINDS}
    for caller in (bare, *callers.values()):
        if not caller.client.wait_for_service(60.0):
            sys.exit(f"nobody offers {caller.client.srv_name}")
    took, bare_took = [-1.0] * count, [-1.0] * count
    begin, done = time.monotonic(), 0
    while done < count or (min(took) < 0.0 and time.monotonic() < begin + count / rate + WAIT_S):
        due = min(count, int((time.monotonic() - begin) * rate))
        while done < due:
            callers[KINDS[done % len(KINDS)][1]].call(done)
            if done % BARE_SHARE == 0:
                bare.call(done)
            done += 1
        for caller in callers.values():
            caller.collect(took)
        bare.collect(bare_took)
        time.sleep(5e-4)
    accepted = callers["shoe/self_calibrate"].accepted
    return {"took": took, "accepted": accepted, "bare": bare_took}


def serve(node: Node) -> None:
    """Offer the service that does nothing, until the process is ended."""
    node.create_service(Trigger, BARE, lambda _, response: response, qos_profile=MANY)
    rclpy.spin(node)


def main() -> None:
    """Call or serve."""
    rclpy.init(args=[])
    if sys.argv[1] == "--serve":
        serve(Node("bare"))
        return
    print(json.dumps(call(Node("flood"), int(sys.argv[1]), float(sys.argv[2]))))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
