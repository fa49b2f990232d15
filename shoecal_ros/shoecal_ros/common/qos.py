"""Quality of service of every topic, in one place.

| publisher's topics                                           | profile     |
|--------------------------------------------------------------|-------------|
| `shoe/voltages` (by the driver)                              | DEVICE      |
| `joint_states`, `imu`, `joint_temperatures` (by the          | DEVICE, RAW |
| simulator, as fast as a real robot and faster)               |             |
| `joint_trajectory`                                           | COMMAND     |
| `shoe/cop`, `shoe/grf`, `shoe/left/…`, `shoe/right/…`        | LIVE        |
| `shoe/model/com`, `shoe/model/cop`                           | LIVE        |
| `shoe/state`, `shoe/calibration`                             | LATCHED     |
| `shoe/armed`                                                 | ARMED       |
| `diagnostics`                                                | DIAGNOSTICS |
| `clock`                                                      | CLOCK       |
| `tf`                                                         | TRANSFORMS  |
| `shoe/markers`                                               | MARKERS     |

Everything is reliable: a reliable subscriber hears nothing of a best-effort
publisher.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

RAW = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
"""Raw measurements, wanted whole by who records them.

A subscriber that keeps all makes a publisher of this profile that runs ahead wait instead of
losing messages, as a simulation may. One that keeps the last few hears those.
"""

DEVICE = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
"""Raw measurements as they happen.

A subscriber that is slow, or was killed, holds up no other: a controller may stand on what
comes next. It finds at least the last ten seconds of a 1000 Hz device when it goes on.
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

ARMED = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""A state of which every change counts: who disarms and arms at once has disarmed."""

SERVICE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Requests: none may be dropped because many come at once."""

DIAGNOSTICS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)

CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Only the present time counts."""

TRANSFORMS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
"""As tf2 subscribes."""

MARKERS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Pictures for viewers: only the newest is worth drawing."""
