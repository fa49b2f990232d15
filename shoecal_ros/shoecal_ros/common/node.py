"""What every node shares: parameters, health, its log and lean subscriptions."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from functools import partial
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from shoecal_core.settings import SettingError, Settings, describe, from_values
from shoecal_ros.common import qos
from shoecal_ros.common.awake_clock import AwakeClock
from shoecal_ros.common.callback_lock import CallbackLock
from shoecal_ros.common.graph_monitor import GraphMonitor
from shoecal_ros.common.health import Health, Level
from shoecal_ros.common.liveness_monitor import LivenessMonitor, end_notice
from shoecal_ros.common.names import short_name
from shoecal_ros.common.parameter_files import ParameterFiles
from shoecal_ros.common.realtime_executor import BATCH, RealtimeExecutor, drained
from shoecal_ros.common.refusal import worded

S = TypeVar("S", bound=Settings)

WATCH_S = 0.1
"""Period of the wall-clock watch: bounds how late a time-out is noticed."""
REPORT_S = 1.0
"""Period of diagnostics."""
ANSWERS = 30
"""Requests that one service answers likewise."""
SEVERITIES = {
    Level.OK: LoggingSeverity.INFO,
    Level.WARN: LoggingSeverity.WARN,
    Level.ERROR: LoggingSeverity.ERROR,
    Level.STALE: LoggingSeverity.ERROR,
}
"""Of lines in the log."""
_BY_ROS = "qos_overrides."
"""Prefix of parameters that publishers and subscriptions declare themselves."""


class ShoecalNode(Node):
    """Base of all nodes.

    Callbacks, jobs and watches run one at a time, so nothing needs a lock; long work belongs
    into a process of its own (`worker.Worker`).

    Attributes:
        health: published once a second and at every change.
        awake: clock of all that is waited for.
        peers: who else is on the node's topics.
        turn: held by whichever thread runs a callback.
        quick: subscriptions that do not wait for the rest of the node.
        mirror: prefix of parameters that only the node itself may change;
            empty: it has none.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.health = Health()
        self.awake = AwakeClock()
        self.turn = CallbackLock()
        self.realtime = RealtimeExecutor(self, self.turn)
        self.mirror = ""
        self._run_id = ""
        self._own_name = name
        self.peers = GraphMonitor(self)
        self._liveness = LivenessMonitor(name)
        self.health.suppose("peers", self.peers.condition)
        self.health.suppose("nodes", self._liveness.condition)
        self._diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", qos.DIAGNOSTICS)
        self.subscribe(DiagnosticArray, "diagnostics", self._liveness.take, qos.DIAGNOSTICS)
        self.wall_timer(REPORT_S, self._report)
        self.wall_timer(WATCH_S, self.watch)

    # For subclasses

    def watch(self) -> None:
        """Called every WATCH_S of wall-clock time, whatever simulated time does."""
        self.awake()
        self.peers.watch()
        self.health.note("peers", self.peers.condition)
        self.health.note("nodes", self._liveness.condition)
        self._log_news()

    def close(self) -> None:
        """Leave the robot safe and release what is held; ROS entities still work."""

    # Parameters

    def settings(self, cls: type[S], section: str = "") -> S:
        """Declare one read-only parameter a field and take their values.

        Args:
            cls: the Settings class.
            section: prefix of the parameters' names, dot included.

        Raises:
            SettingError: names the parameter and the cure.
        """
        values: dict[str, object] = {}
        for entry in describe(cls):
            unit = f" [{entry.unit}]" if entry.unit else ""
            values[entry.name] = self.declare_parameter(
                f"{section}{entry.name}",
                entry.default,
                # Any type: a whole number stands for a real one, and the check says what is wrong.
                ParameterDescriptor(
                    description=f"{entry.doc}{unit}", read_only=True, dynamic_typing=True
                ),
            ).value
        return from_values(cls, values)

    def check_overrides(self, files: ParameterFiles) -> None:
        """Every parameter file reaches this node, and every parameter in it is one of its own.

        ROS itself passes over the others in silence: a limit that is misspelt would not be in
        force, unnoticed. Only those for all nodes (`/**`) may be another node's; they
        are logged.

        Args:
            files: that the node was given.

        Raises:
            UnusedFileError: names the file, and the key it should have.
            SettingError: names the parameter, and those that look like it.
        """
        full_name = self.get_fully_qualified_name()
        files.check(full_name, self._own_name)
        shared = files.shared(full_name)
        # No public attribute shows what was given to the node.
        given = [name for name in self._parameter_overrides if not name.startswith(_BY_ROS)]
        for name in given:
            if self.has_parameter(name):
                continue
            if name in shared:
                self.log(Level.WARN, f"{name}: is given to all nodes, and no parameter of this one")
            else:
                known = sorted(self.list_parameters([], 0).names)
                alike = [full for full in known if full.endswith(f".{name}")]
                alike = alike or get_close_matches(name, known)
                hint = f" (perhaps {' or '.join(alike)})" if alike else ""
                raise SettingError(
                    name,
                    f"node {self.get_name()} has no such parameter{hint}; correct its name where "
                    "the node is given its parameters",
                )

    def seal(self) -> None:
        """Let parameters stay as they are: this node has begun to work with them.

        Those that ROS declares itself, `use_sim_time` above all, are not read-only by themselves.
        """
        self.add_on_set_parameters_callback(self._refuse)

    # Topics

    def create_publisher(self, *args: Any, **kwargs: Any) -> Publisher:
        """As rclpy's, with no events of its own.

        Each is looked at whenever the node wakes up, which took longer than all it then does; what
        does not fit is reported by `peers`.
        """
        kwargs.setdefault("event_callbacks", PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(*args, **kwargs)

    def create_subscription(self, *args: Any, **kwargs: Any) -> Subscription:
        """Likewise; and an executor that waits for a reader's events is woken by its data, too."""
        kwargs.setdefault(
            "event_callbacks", SubscriptionEventCallbacks(use_default_callbacks=False)
        )
        return super().create_subscription(*args, **kwargs)

    def subscribe(
        self,
        kind: type[Any],
        topic: str,
        callback: Callable[[list[Any]], None],
        profile: QoSProfile,
        *,
        raw: bool = False,
    ) -> Subscription:
        """Subscribe in batches: waking up costs far more than a message.

        Args:
            kind: of message.
            topic: relative name.
            callback: takes all messages that have come, in order (serialised ones where raw).
            profile: quality of service.
            raw: do not deserialise.
        """

        def take(first: object) -> None:
            with subscription.handle:
                others = drained(subscription, kind, BATCH - 1, raw=raw)
            callback([first, *others])

        subscription = self.create_subscription(kind, topic, take, profile, raw=raw)
        return subscription

    # Services

    def serve(self, kind: type[Any], name: str, callback: Callable[[Any, Any], Any]) -> Service:
        """Offer a service in batches, so that who calls it all the time holds nothing up.

        Args:
            kind: of service.
            name: relative name.
            callback: takes request and empty response, gives the response; answers at once, or is
                a coroutine function, of which several may be under way.
        """

        def others() -> Iterator[tuple[Any, Any]]:
            for _ in range(ANSWERS):
                with service.handle:
                    request, header = service.handle.service_take_request(kind.Request)
                if header is None:
                    return
                yield request, header

        def answer(first: object, response: object) -> object:
            answered = callback(first, response)
            for request, header in others():
                service.send_response(callback(request, kind.Response()), header)
            return answered

        async def answer_later(request: object, header: object) -> None:
            service.send_response(await callback(request, kind.Response()), header)

        async def answer_meanwhile(first: object, response: object) -> object:
            for request, header in others():
                self.start(partial(answer_later, request, header))
            return await callback(first, response)

        later = inspect.iscoroutinefunction(callback)
        service = self.create_service(
            kind, name, answer_meanwhile if later else answer, qos_profile=qos.SERVICE,
            callback_group=ReentrantCallbackGroup() if later else None,
        )  # fmt: skip
        return service

    # Time

    @property
    def simulated(self) -> bool:
        """Whether the node's time is simulated (`use_sim_time`)."""
        return bool(self.get_parameter("use_sim_time").value)

    @property
    def now_ns(self) -> int:
        """The node's time, simulated or not [ns]."""
        return int(self.get_clock().now().nanoseconds)

    def wall_timer(self, period_s: float, callback: Callable[[], None]) -> Timer:
        """A timer that does not follow simulated time."""
        return self.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def wake(self) -> None:
        """Let waiting jobs look again; the one method for other threads."""
        if self.executor is not None:
            self.executor.wake()

    def start(self, job: Callable[[], Any]) -> None:
        """Run a coroutine function concurrently."""
        assert self.executor is not None, "nodes start jobs when they spin"
        self.executor.create_task(job)

    # The process

    def end(self, when_safe: Callable[[], None] = lambda: None) -> None:
        """Hear no more, then close and destroy the node.

        Args:
            when_safe: called once the node has closed: what follows concerns no robot.
        """
        self.realtime.close()
        with self.turn:
            self.close()
            when_safe()
            if self.context.ok():
                self._diagnostics.publish(end_notice(self.get_name()))
        with contextlib.suppress(rclpy_implementation.InvalidHandle):
            self.destroy_node()

    # Logs

    @property
    def run_id(self) -> str:
        """Of the job under way; it stands in every line of the log. Empty: there is none."""
        return self._run_id

    @contextmanager
    def working(self, what: str, run_id: str) -> Iterator[None]:
        """Log that something is being done, and how it ends; one thing at a time.

        Args:
            what: is being done.
            run_id: of the job that it belongs to, as given in the request; empty: none.
        """
        self._run_id = short_name(run_id)
        try:
            self.log(Level.OK, f"{what} begins")
            yield
            self.log(Level.OK, f"{what} done")
        except Exception as error:
            self.log(Level.WARN, f"{what} ended: {worded(error)}")
            raise
        finally:
            self._run_id = ""

    def log(self, level: Level, line: str) -> None:
        """Write a line, with the id of the job under way."""
        reported = f"[{self.run_id}] {line}" if self.run_id else line
        # A logger's methods look for who called in all modules there are, and hold up what is live
        # for a twentieth of a second.
        rclpy_implementation.rclpy_logging_rcutils_log(
            SEVERITIES[level], self.get_logger().name, reported, "log", __file__, 0
        )

    # Inside

    def _refuse(self, parameters: list[Parameter]) -> SetParametersResult:
        names = [parameter.name for parameter in parameters]
        if self.mirror and all(name.startswith(self.mirror) for name in names):
            return SetParametersResult(successful=True)
        reported = "parameters stay while a node runs; start it again with other ones"
        return SetParametersResult(reason=f"{', '.join(names)}: {reported}")

    def _log_news(self) -> None:
        news = self.health.news()
        for subject, condition in news.items():
            code = "" if condition.level is Level.OK else f" ({condition.code})"
            self.log(condition.level, f"{subject}: {condition.message}{code}")
        if news:
            self._report()

    def _report(self) -> None:
        array = DiagnosticArray()
        array.header.stamp = self.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=bytes([condition.level]),
                name=f"{self.get_name()}: {subject}",
                message=condition.message,
                hardware_id=self.get_name(),
                values=[
                    KeyValue(key=key, value=value)
                    for key, value in self.health.values(subject).items()
                ],
            )
            for subject, condition in self.health.conditions.items()
        ]
        self._diagnostics.publish(array)
