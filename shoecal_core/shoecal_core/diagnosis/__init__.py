"""Where model and reality differ, which unmodelled effect causes it, how far it shrinks with it."""
