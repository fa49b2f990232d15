"""shoecal_ros: the ROS 2 nodes around shoecal_core."""
