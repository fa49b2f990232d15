"""What stamps of time show of the clock that made them."""

CLOCK_SET_NS = 1_000_000_000
"""Stamps that fall back further than this: a clock was set, or simulated time started again."""
