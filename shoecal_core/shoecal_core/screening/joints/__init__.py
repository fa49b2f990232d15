"""Faults of joint angles: steps, held values, zeros that move."""
