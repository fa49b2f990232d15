"""Calls services of the calibrator at a steady rate: a program of its own, for `flood`.

    python flood_caller.py CALLS RATE REQUEST...

It sends the serialised requests to `shoe/set_calibration` in turn, and prints one line of JSON: for
every call how long its answer took [s], -1 where none came, how many self-calibrations were begun,
and which calls put a calibration in force. No executor: this must not be what is slow.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import rclpy
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


class Caller:
    """One client, and its calls that are not answered yet."""

    def __init__(self, node: Node, kind: type[Any], name: str, requests: Sequence[Any] = ()):
        self._client = node.create_client(kind, name, qos_profile=MANY)
        self._requests = cycle(requests or [kind.Request()])
        self._response = kind.Response
        self._sent: dict[int, tuple[int, float]] = {}
        if not self._client.wait_for_service(60.0):
            sys.exit(f"nobody offers {name}")

    def call(self, number: int) -> None:
        """Call; the call has this number."""
        with self._client.handle:
            sequence = self._client.handle.send_request(next(self._requests))
        self._sent[sequence] = number, time.monotonic()

    def answers(self) -> Iterator[tuple[int, float, Any]]:
        """Number of each call that is answered now, how long that took [s], and the response."""
        while True:
            with self._client.handle:
                header, response = self._client.handle.take_response(self._response)
            if header is None:
                return
            number, sent = self._sent.pop(header.request_id.sequence_number)
            yield number, time.monotonic() - sent, response


def call(node: Node, count: int, rate: float, requests: Sequence[Any]) -> dict[str, object]:
    """Call as often and as quickly as asked for; what came of it."""
    start = Caller(node, SelfCalibrate, "shoe/self_calibrate")
    get = Caller(node, GetCalibration, "shoe/get_calibration")
    back = Caller(node, Trigger, "shoe/rollback")
    change = Caller(node, SetCalibration, "shoe/set_calibration", requests)
    in_turn = (*[start] * 7, get, back, change)
    _until_known(Caller(node, GetCalibration, "shoe/get_calibration"))
    freeze_objects()
    took, changes, jobs = [-1.0] * count, [], 0
    begin, done = time.monotonic(), 0
    while done < count or (min(took) < 0.0 and time.monotonic() < begin + count / rate + WAIT_S):
        due = min(count, int((time.monotonic() - begin) * rate))
        while done < due:
            in_turn[done % len(in_turn)].call(done)
            done += 1
        for caller in (start, get, back, change):
            for number, seconds, response in caller.answers():
                took[number] = seconds
                jobs += caller is start and response.accepted
                if caller in (back, change) and response.success:
                    changes.append(number)
        time.sleep(LOOK_S)
    return {"took": took, "changes": changes, "jobs": jobs}


def _until_known(last: Caller) -> None:
    """Wait until the calibrator answers the client made last: it knows of all before then."""
    while True:
        last.call(0)
        again = time.monotonic() + AGAIN_S
        while time.monotonic() < again:
            if any(last.answers()):
                return
            time.sleep(LOOK_S)


def main() -> None:
    """Call and print what came of it."""
    count, rate, *files = sys.argv[1:]
    requests = [
        deserialize_message(Path(file).read_bytes(), SetCalibration.Request) for file in files
    ]
    rclpy.init(args=[])
    print(json.dumps(call(Node("flood"), int(count), float(rate), requests)))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
