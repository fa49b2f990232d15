"""Real node processes, and a client that talks to them over DDS."""

from __future__ import annotations

import inspect
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from std_msgs.msg import Bool

from ros.introduction import Introduction
from shoecal_core.end_with_parent import ending_with_parent
from shoecal_core.workspace import ros_environment
from shoecal_ros.common import qos

TIMEOUT_S = 120.0
"""Ends a wait that is in vain, on a busy machine too."""
END_S = 300.0


class Received:
    """Messages of one topic, as they come."""

    def __init__(self) -> None:
        self.messages: list[Any] = []

    def __len__(self) -> int:
        return len(self.messages)

    @property
    def last(self) -> Any:
        return self.messages[-1]


class World:
    """Processes and a client node; everything is ended at the end.

    Processes end with the thread that starts them, too: where a test is killed, none is left in its
    ROS domain.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.timeout_s = TIMEOUT_S
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = Node(
            "tester",
            context=self._context,
            parameter_overrides=[Parameter("use_sim_time", value=False)],
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._companions: dict[str, SingleThreadedExecutor] = {}
        self._heard: dict[str, Received] = {}
        self._action_clients: dict[str, ActionClient] = {}
        self._diagnostics_before: dict[str, int] = {}

    # Processes

    def start(
        self,
        node: str,
        parameters: Mapping[str, object] | None = None,
        *arguments: str,
        name: str = "",
        script: Path | None = None,
        log_to: int | None = None,
    ) -> subprocess.Popen[bytes]:
        """Start one node with parameters and ROS arguments, under its own name or another.

        Where a script is given it is the program. What it says is told to a file of its own, or to
        a descriptor.
        """
        name = name or node
        pairs = [f"{key}:={_yaml(value)}" for key, value in (parameters or {}).items()]
        program = ["-m", f"shoecal_ros.nodes.{node}"] if script is None else [str(script)]
        command = [sys.executable, *program, "--ros-args"]
        command += [part for pair in pairs for part in ("-p", pair)]
        # By one that had this name before.
        self.forget(name)
        with self._log(name).open("wb") as file:
            log = file if log_to is None else log_to
            process = subprocess.Popen(
                ending_with_parent([*command, *arguments]),
                env=ros_environment(), stderr=log, stdout=log,
            )  # fmt: skip
        self.processes[name] = process
        return process

    def output(self, node: str) -> str:
        return self._log(node).read_text()

    def until_logged(self, node: str, text: str) -> None:
        """Wait until a text stands in a node's output."""
        self.until(lambda: text in self.output(node), waited_for=f"'{text}' in the log of {node}")

    def stop(self, node: str) -> int:
        """End a node as Ctrl-C does; its exit code."""
        process = self.processes.pop(node)
        process.send_signal(signal.SIGINT)
        return process.wait(END_S)

    def kill(self, node: str) -> None:
        """End a node as kill -9 does."""
        process = self.processes.pop(node)
        process.kill()
        process.wait()

    def ended(self, node: str) -> int:
        """Wait until a node ends by itself; its exit code."""
        return self.processes.pop(node).wait(self.timeout_s)

    # The client

    def companion(self, name: str) -> Node:
        """Another node, as if it were another process, until it is dismissed."""
        context = rclpy.Context()
        rclpy.init(context=context)
        node = Node(name, context=context)
        executor = self._companions[name] = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        return node

    def dismiss(self, node: Node) -> None:
        """End a companion."""
        self._companions.pop(node.get_name()).shutdown()
        node.destroy_node()
        rclpy.shutdown(context=node.context)

    def receive(self, kind: type[Any], topic: str, profile: Any = qos.RAW) -> Received:
        heard = self._heard.get(topic)
        if heard is None:
            heard = self._heard[topic] = Received()
            self.node.create_subscription(kind, topic, heard.messages.append, profile)
        return heard

    def until(
        self,
        condition: Callable[[], object],
        timeout_s: float | None = None,
        waited_for: str = "",
    ) -> None:
        """Wait for a condition.

        Args:
            condition: looked at again and again.
            timeout_s: in place of the world's; then it fails, with the nodes' output [s].
            waited_for: in the error message, in place of the condition's source.
        """
        limit_s = self.timeout_s if timeout_s is None else timeout_s
        deadline = time.monotonic() + limit_s
        while not condition():
            for name, process in self.processes.items():
                assert process.poll() is None, f"{name} ended:\n{self.output(name)}"
            assert time.monotonic() < deadline, "\n".join(
                [
                    f"waited {limit_s:g} s in vain for {waited_for or _source(condition)}",
                    *(f"--- {name}\n{self.output(name)}" for name in self.processes),
                ]
            )
            self._executor.spin_once(timeout_sec=0.05)
            for executor in self._companions.values():
                executor.spin_once(timeout_sec=0.0)

    def publisher(self, kind: type[Any], topic: str, profile: Any = qos.RAW) -> Any:
        """A publisher that other nodes subscribe to: from now on nothing is lost to them."""
        publisher = self.node.create_publisher(kind, topic, profile)
        self.until(lambda: self._subscribers(publisher.topic_name))
        for node in self._subscribers(publisher.topic_name):
            self.until_discovered_by(node)
        return publisher

    def until_discovered_by(self, node: str, companion: Node | None = None) -> None:
        """Wait until a node knows all that the client has made: from now on nothing is lost to it.

        What was published by then it has as a rule taken, too, but nothing ensures that: messages
        go by another way than the question and its answer here.

        Args:
            node: name.
            companion: in place of the client.
        """
        introduction = Introduction(companion or self.node, node)
        self.until(lambda: introduction.done, waited_for=f"an answer of {node}")
        introduction.end()

    def arm(self, node: str) -> Publisher:
        """Tell a node that the robot is armed, in place of a planner; give it time to take that."""
        publisher: Publisher = self.publisher(Bool, "shoe/armed", qos.LATCHED)
        publisher.publish(Bool(data=True))
        self.until_discovered_by(node)
        return publisher

    def call(self, kind: type[Any], name: str, request: Any) -> Any:
        """Call a service."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready)
        self._until_known_to_server(name)
        future = client.call_async(request)
        self.until(future.done)
        self.node.destroy_client(client)
        return future.result()

    def goal(self, kind: type[Any], name: str, goal: Any) -> Goal:
        """Send a goal; nothing of what is told of it is lost."""
        client = self._action_clients.get(name)
        if client is None:
            client = self._action_clients[name] = ActionClient(self.node, kind, name)
        self.until(client.server_is_ready)
        self._until_known_to_server(f"{name}/_action/send_goal")
        return Goal(self, client, goal)

    def diagnosis(self, node: str, subject: str) -> Any:
        """The last diagnostic of a node's subject, None before there was one."""
        before = self._diagnostics_before.get(node, 0)
        for message in reversed(self._diagnostics.messages[before:]):
            for status in message.status:
                if status.name == f"{node}: {subject}":
                    return status
        return None

    def forget(self, node: str) -> None:
        """Let what a node told of itself so far count no more."""
        self._diagnostics_before[node] = len(self._diagnostics.messages)

    def until_reported(
        self, node: str, subject: str, text: str, timeout_s: float | None = None
    ) -> Any:
        """Wait until a node's diagnostic of a subject contains a text."""
        self.until(
            lambda: (found := self.diagnosis(node, subject)) and text in found.message,
            timeout_s,
            f"'{text}' in the diagnostic {node}: {subject}",
        )
        return self.diagnosis(node, subject)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        codes = {}
        try:
            for process in self.processes.values():
                process.send_signal(signal.SIGINT)
            for name, process in self.processes.items():
                codes[name] = process.wait(END_S)
        finally:
            for process in self.processes.values():
                process.kill()
            for executor in list(self._companions.values()):
                for node in executor.get_nodes():
                    self.dismiss(node)
            self._executor.shutdown()
            # They outlive their node: a server of a failed test would answer the next one's goals.
            for one in list(self.node.waitables):
                if isinstance(one, ActionClient | ActionServer):
                    one.destroy()
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)
        if kind is None:
            failed = {name: self.output(name) for name, code in codes.items() if code}
            failed = {name: said for name, said in failed.items() if not middleware_failed(said)}
            assert not failed, failed

    @property
    def _diagnostics(self) -> Received:
        return self.receive(DiagnosticArray, "diagnostics", qos.DIAGNOSTICS)

    def _until_known_to_server(self, service: str) -> None:
        """Wait until whoever offers a service knows of its clients: no answer is lost."""
        while not (node := self._server(service)):
            self.until(lambda: self._server(service))
        self.until_discovered_by(node)

    def _subscribers(self, topic: str) -> set[str]:
        """Full names of the other nodes on a topic; empty while there is none, or one unnamed."""
        found = {
            f"{info.node_namespace.rstrip('/')}/{info.node_name}"
            for info in self.node.get_subscriptions_info_by_topic(topic)
        } - {self.node.get_fully_qualified_name()}
        return set() if any("UNKNOWN" in name for name in found) else found

    def _server(self, service: str) -> str:
        """Full name of a node that offers a service; empty: none is known yet.

        By the topic of its requests: asked by a node's name, the middleware tells of one that has
        ended for 20 s yet, and of its successor nothing.
        """
        topic = f"rq{self.node.resolve_service_name(service)}Request"
        found = self.node.get_subscriptions_info_by_topic(topic, no_mangle=True)
        for info in found:
            if "UNKNOWN" not in info.node_name:
                return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        return ""

    def _log(self, node: str) -> Path:
        return self.folder / f"{node}.log"


def middleware_failed(output: str) -> bool:
    """Whether a process failed because the middleware hung or crashed while it was destroyed.

    Fast DDS does so about once in some thousand ends, after another process was killed. By then the
    node had closed, which `process.run` ensures before it limits the time: no robot was in motion.
    """
    destroying = r"most recent call first\):\n  File \S*/rclpy/node.py\S* line \d+ in destroy_node"
    hung, crashed = (
        rf"^Timeout .*{destroying}",
        rf"^Fatal Python error: .*^Current thread \S+ \({destroying}",
    )
    return bool(re.search(f"{hung}|{crashed}", output, re.DOTALL | re.MULTILINE))


class Goal:
    """A goal that was sent."""

    def __init__(self, world: World, client: ActionClient, goal: Any) -> None:
        self.feedback: list[Any] = []
        self._world = world
        sent = client.send_goal_async(goal, lambda message: self.feedback.append(message.feedback))
        world.until(sent.done)
        self._handle = sent.result()
        assert self._handle.accepted
        self._result = self._handle.get_result_async()

    @property
    def done(self) -> bool:
        return bool(self._result.done())

    def cancel(self) -> None:
        self._world.until(self._handle.cancel_goal_async().done)

    def result(self, timeout_s: float | None = None) -> Any:
        self._world.until(self._result.done, timeout_s, "the result of a goal")
        return self._result.result().result


def _source(condition: Callable[[], object]) -> str:
    """Of a lambda expression; of other functions the name."""
    name = getattr(condition, "__qualname__", repr(condition))
    if "<lambda>" not in name:
        return str(name)
    return inspect.getsource(condition).strip()


def _yaml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, str | Path) else str(value)
