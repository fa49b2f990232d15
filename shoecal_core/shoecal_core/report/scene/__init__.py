"""Pictures of the robot in three dimensions, drawn by MuJoCo without a window."""
