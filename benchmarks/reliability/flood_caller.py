"""Calls services of the calibrator at a steady rate: a program of its own, for `flood`.

    python flood_caller.py CALLS RATE REQUEST...
    python flood_caller.py --serve

The first sends the serialised requests to `shoe/set_calibration` in turn, and prints one line of
JSON: for every call how long its answer took [s], -1 where none came, the same of a service that
does nothing (the second form offers it), how many self-calibrations were begun, and which calls put
a calibration in force. No executor: this must not be what is slow.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import cycle, repeat
from pathlib import Path
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from shoecal_msgs.srv import GetCalibration, SelfCalibrate, SetCalibration
from std_srvs.srv import Trigger

from shoecal_ros.common.process import freeze_objects

WAIT_S = 60.0
"""For what is not answered when the last call was made."""
AGAIN_S = 1.0
LOOK_S = 2e-3
"""How closely answers are timed: looking more often takes a core from those who are called."""
MANY = QoSProfile(depth=1000)
CHANGE = "shoe/set_calibration"
BARE, BARE_SHARE = "bare", 20
"""A service that does nothing; called once in so many calls."""
KINDS: tuple[tuple[type[Any], str], ...] = (
    *((SelfCalibrate, "shoe/self_calibrate"),) * 7,
    (GetCalibration, "shoe/get_calibration"),
    (Trigger, "shoe/rollback"),
    (SetCalibration, CHANGE),
)


class Caller:
    """One client, and what became of its calls."""

    def __init__(self, node: Node, kind: type[Any], name: str) -> None:
        self.client: Client = node.create_client(kind, name, qos_profile=MANY)
        self.accepted = 0
        self.succeeded: list[int] = []
        self.requests: Iterator[Any] = repeat(kind.Request())
        self._kind = kind
        self._sent: dict[int, tuple[int, float]] = {}

    def call(self, number: int) -> None:
        """Call; the call has this number."""
        with self.client.handle:
            sequence = self.client.handle.send_request(next(self.requests))
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
            if getattr(response, "success", False):
                self.succeeded.append(number)


def call(node: Node, count: int, rate: float, requests: Sequence[Any]) -> dict[str, object]:
    """Call as often and as quickly as asked for; what came of it."""
    bare = Caller(node, Trigger, BARE)
    callers = {name: Caller(node, kind, name) for kind, name in KINDS}
    callers[CHANGE].requests = cycle(requests)
    for caller in (bare, *callers.values()):
        if not caller.client.wait_for_service(60.0):
            sys.exit(f"nobody offers {caller.client.srv_name}")
    _until_known(Caller(node, GetCalibration, "shoe/get_calibration"))
    freeze_objects()
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
        time.sleep(LOOK_S)
    return {
        "took": took,
        "accepted": callers["shoe/self_calibrate"].accepted,
        "bare": bare_took,
        "changes": [*callers[CHANGE].succeeded, *callers["shoe/rollback"].succeeded],
    }


def _until_known(last: Caller) -> None:
    """Wait until the calibrator answers the client made last: it knows of all before then."""
    answered = [-1.0]
    while min(answered) < 0.0:
        last.call(0)
        again = time.monotonic() + AGAIN_S
        while min(answered) < 0.0 and time.monotonic() < again:
            last.collect(answered)
            time.sleep(LOOK_S)


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
    count, rate, *files = sys.argv[1:]
    requests = [
        deserialize_message(Path(file).read_bytes(), SetCalibration.Request) for file in files
    ]
    print(json.dumps(call(Node("flood"), int(count), float(rate), requests)))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
