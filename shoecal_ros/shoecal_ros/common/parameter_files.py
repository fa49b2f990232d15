"""The parameter files that a node was started with: nothing in them is passed over in silence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shoecal_core.errors import ShoecalError
from shoecal_core.parameter_file import read_sections


class UnusedFileError(ShoecalError):
    """A parameter file that sets nothing of the node that it was given to, though it should."""


def given_files(arguments: Sequence[str]) -> list[Path]:
    """Files after `--params-file` among the ROS arguments of a command line."""
    files, ros = [], False
    for argument, following in zip(arguments, [*arguments[1:], ""], strict=True):
        if argument == "--ros-args":
            ros = True
        elif argument == "--":
            ros = False
        elif ros and argument == "--params-file" and following:
            files.append(Path(following))
    return files


class ParameterFiles:
    """All files that were given to one node."""

    def __init__(self, arguments: Sequence[str]) -> None:
        """Read them.

        Args:
            arguments: of the command line.

        Raises:
            FileError: for a file that is missing or broken.
        """
        self._sections = {path: read_sections(path) for path in given_files(arguments)}

    def check(self, full_name: str, own_name: str) -> None:
        """Every file sets something of the node, and what names the node reaches it.

        Args:
            full_name: of the node, with its namespace.
            own_name: as its program calls it, whatever it was renamed to.

        Raises:
            UnusedFileError: ROS itself would pass over the file in silence.
        """
        names = {own_name, full_name.rpartition("/")[2]}
        for path, sections in self._sections.items():
            missed = [
                one.key for one in sections if one.last in names and not one.matches(full_name)
            ]
            reached = any(one.matches(full_name) for one in sections)
            if reached and not missed:
                continue
            own = full_name.rpartition("/")[2]
            keys = ", ".join(missed or (one.key for one in sections)) or "nothing"
            raise UnusedFileError(
                f"{path}: has parameters of {keys}, which do not reach this node, {full_name}; "
                f"name their key /**/{own}, or do not give the file to this node"
            )

    def shared(self, full_name: str) -> set[str]:
        """Parameters that only sections for any node set, as `/**`.

        They may be meant for other nodes.
        """
        given = (one for every in self._sections.values() for one in every)
        own = [one for one in given if one.matches(full_name)]
        for_any = {name for one in own if one.any_node for name in one.names()}
        return for_any - {name for one in own if not one.any_node for name in one.names()}
