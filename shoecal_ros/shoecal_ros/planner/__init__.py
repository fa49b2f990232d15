"""The planner: motions on request, sent to the robot and watched."""
