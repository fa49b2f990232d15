"""Quality of service of every topic, in one place.

| publisher's topics                                           | profile     |
|--------------------------------------------------------------|-------------|
| `joint_states`, `shoe/voltages` (by simulator and driver)    | RAW         |
| `imu`, `joint_temperatures` (by the simulator)               | RAW         |
| `joint_trajectory`                                           | COMMAND     |
| `shoe/cop`, `shoe/grf`, `shoe/left/…`, `shoe/right/…`        | LIVE        |
| `shoe/model/com`, `shoe/model/cop`                           | LIVE        |
| `shoe/state`, `shoe/calibration`, `shoe/armed`               | LATCHED     |
| `diagnostics`                                                | DIAGNOSTICS |
| `clock`                                                      | CLOCK       |
| `tf`                                                         | TRANSFORMS  |

Everything is reliable: a reliable subscriber hears nothing of a best-effort
publisher.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

RAW = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
"""Raw measurements, wanted whole by who records them.

A subscriber that keeps all, too, makes a publisher that runs ahead wait instead of losing
messages; see `runtime.publish_all`. One that keeps the last few hears those.
"""

COMMAND = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
"""Commands: few, each of them counts."""

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""For subscribers that need the present only, and are to be woken by it."""

EITHER = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For subscribers of what robots publish reliably or not: both are heard."""

LIVE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
"""What controllers read: the newest matters."""

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""States: the last one reaches those who come later."""

SERVICE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Requests: none may be dropped because many come at once."""

DIAGNOSTICS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)

CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Only the present time counts."""

TRANSFORMS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
"""As tf2 subscribes."""
