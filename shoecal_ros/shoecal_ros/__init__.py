"""shoecal_ros: the ROS 2 nodes around shoecal_core."""

import shoecal_core.one_thread  # noqa: F401  (before anything that loads numpy)
