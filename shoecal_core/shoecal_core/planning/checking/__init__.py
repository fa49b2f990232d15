"""The independent check of a motion."""
