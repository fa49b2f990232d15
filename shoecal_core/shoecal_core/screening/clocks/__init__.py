"""How the times of readings and joint angles go together."""
