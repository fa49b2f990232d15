"""Files of every kind, mutated: each is refused with one line that names it, or loads as it says.

The files are those of config/, and a calibration, a session, runs and logs of serial bytes that are
made here. They are mutated as bytes (bits, cuts, pieces repeated or moved, lengths and numbers at
their extremes), as trees (values of another kind, keys gone or renamed, deep nesting) and with
texts that a careless parser would run, fetch or unfold. A load gets 2 GiB and 10 s of the
processor's time, opens no other file and runs nothing.

- Calibration: one that loads, saved and loaded again, is the same.
- Recording: its records are changed too, with checksums made right again, and its chunks unfold
  into gigabytes. Half of the mutants are read, the others recovered first. Where no checksum was
  made right, all that is read was recorded.
- Serial log: binary packets or lines of text. The replay ends, its stamps grow, and every frame of
  the binary protocol was sent (unless its checksum was made right on purpose).
- Session: also files gone, swapped, renamed, or links, folders and pipes in their place. Every run
  that can be read has the readings that were recorded.
- URDF: also entities, and meshes that name other files. The model that loads is finite, and its
  mass is the robot's.
- YAML: robots, shoes, realities and parameters of nodes. Robots and shoes that load are finite.
"""

from __future__ import annotations

from functools import partial

from reliability.loading import Lay, try_mutants
from reliability.mutated_files import CONFIGURATION, URDFS, lay_calibration, lay_config
from reliability.mutated_recordings import lay_run, lay_serial_log, lay_session
from reliability.mutations import mutate_xml, mutate_yaml
from reliability.row import Row


def _row(key: str, fault: str, holds: str, codes: set[str], lay: Lay) -> Row:
    return Row(
        key=f"mutants-{key}",
        fault=f"mutated {fault}",
        holds=f"{holds}; at most 2 GiB and 10 s of the processor",
        tries=10_000,
        step=500,
        run=partial(try_mutants, lay, frozenset(codes)),
    )


_PLAIN = {"file-missing", "file-unreadable", "file-too-large", "file-syntax"}
"""Codes of files of every kind, from the system or the parser."""
_REFUSED = "refused with one line that names the file, or"

ROWS = (
    _row(
        "calibration",
        "calibration",
        f"{_REFUSED} loaded as it says, and nothing of it runs",
        {"file-syntax", "file-too-large", "field", "version", "calibration-file"},
        lay_calibration,
    ),
    _row(
        "mcap",
        "recording (MCAP), read and recovered",
        f"{_REFUSED} read as it was recorded",
        {"recording", "damaged", "version", "file-too-large"},
        lay_run,
    ),
    _row(
        "serial",
        "log of serial bytes, replayed",
        "replayed to its end without an exception and without a frame that was never sent, or "
        "refused in one line",
        {"replay"},
        lay_serial_log,
    ),
    _row(
        "session",
        "session: session.yaml and the files of the folder",
        f"{_REFUSED} read as it was recorded",
        _PLAIN | {"field", "version", "session", "recording", "damaged", "hash-mismatch"},
        lay_session,
    ),
    _row(
        "urdf",
        "URDF, entities and meshes that name other files among them",
        f"{_REFUSED} a model of finite numbers, and nothing is fetched",
        {"file-syntax", "urdf"},
        partial(lay_config, URDFS, mutate_xml),
    ),
    _row(
        "yaml",
        "YAML: robot, shoe, reality, driver, settings",
        f"{_REFUSED} loaded as it says, and nothing of it runs",
        _PLAIN | {"field", "version", "urdf"},  # a robot file may name another file as its URDF
        partial(lay_config, CONFIGURATION, mutate_yaml),
    ),
)
