"""The command line: parsers, one module a command, and what they print."""

from shoecal_core.cli.program import main

__all__ = ["main"]
