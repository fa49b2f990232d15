"""Subscriptions in a thread of their own, for what must not wait for a whole node.

An executor looks at everything that a node has, several times a message; here a few subscriptions
alone are waited for. Callbacks still come one at a time, in the node's turn, so nothing needs
another lock.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from shoecal_ros.common.callback_lock import CallbackLock

WAIT_NS = 100_000_000
"""Longest wait for a message: bounds how long closing takes."""
BATCH = 200
"""Messages that one subscription hands over before others get their turn."""


def drained(subscription: Subscription, kind: type[Any], most: int, *, raw: bool) -> list[Any]:
    """What has come, in order, its handle being held."""
    batch: list[Any] = []
    while len(batch) < most:
        taken = subscription.handle.take_message(kind, raw)
        if taken is None:
            break
        batch.append(taken[0])
    return batch


class _PassedBy(MutuallyExclusiveCallbackGroup):
    """The executor leaves what is in here alone."""

    def can_execute(self, entity: Any) -> bool:
        del entity
        return False


@dataclass(frozen=True)
class _Listening:
    """One subscription, and who takes its messages."""

    subscription: Subscription
    kind: type[Any]
    raw: bool
    callback: Callable[[list[Any]], None]

    def take(self) -> list[Any]:
        """What has come, in order."""
        return drained(self.subscription, self.kind, BATCH, raw=self.raw)


class RealtimeExecutor:
    """Takes messages in batches where they come faster than they are dealt with.

    Attributes:
        error: what a callback has ended with, and the thread with it; None while all is well.
    """

    def __init__(self, node: Node, turn: CallbackLock) -> None:
        """Nothing is heard yet.

        Args:
            node: that listens.
            turn: held while a callback runs.
        """
        self.error: BaseException | None = None
        self._node, self._turn = node, turn
        self._listening: tuple[_Listening, ...] = ()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True, name="quick")

    def subscribe(
        self,
        kind: type[Any],
        topic: str,
        callback: Callable[[list[Any]], None],
        profile: QoSProfile,
        *,
        raw: bool = False,
    ) -> None:
        """Listen to a topic, before the thread is started; those listened to first come first.

        Args:
            kind: of message.
            topic: relative name.
            callback: takes all messages that have come, in order (serialised ones where raw).
            profile: quality of service.
            raw: do not deserialise.
        """
        subscription = self._node.create_subscription(
            kind, topic, lambda _: None, profile, callback_group=_PassedBy(), raw=raw
        )
        self._listening += (_Listening(subscription, kind, raw, callback),)

    def start(self) -> None:
        """Begin to listen, where there is anything to listen to."""
        if self._listening:
            self._thread.start()

    def close(self) -> None:
        """Listen no more; no callback runs afterwards."""
        self._closing.set()
        if self._thread.ident is not None:
            self._thread.join()

    def _listen(self) -> None:
        context, listening = self._node.context, self._listening
        handles = [one.subscription.handle for one in listening]
        with ExitStack() as held:
            for handle in (*handles, context.handle):
                held.enter_context(handle)
            waiting = rclpy_implementation.WaitSet(len(handles), 0, 0, 0, 0, 0, context.handle)
            while not self._closing.is_set() and context.ok() and self.error is None:
                waiting.clear_entities()
                for handle in handles:
                    waiting.add_subscription(handle)
                waiting.wait(WAIT_NS)
                for index, one in enumerate(listening):
                    if waiting.is_ready("subscription", index):
                        self._hand_over(one)

    def _hand_over(self, one: _Listening) -> None:
        batch = one.take()
        with self._turn:
            if not batch or self._closing.is_set():
                return
            try:
                one.callback(batch)
            except BaseException as error:  # noqa: BLE001 (raised where the node is spun)
                self.error = error
