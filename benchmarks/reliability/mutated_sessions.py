"""Sessions whose files were tampered with.

A session of two runs. Mutants of its session.yaml, as of other YAML files; and of what else the
folder holds: files swapped, gone, empty, links and pipes in their place, runs under another's
name, files of a robot or shoe that the runs were not recorded with. What is open is then listed and
every run read as any command would. The session is refused with one line that names a file, or
what is read are the runs as they were recorded.
"""

from __future__ import annotations

import os
import shutil
from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.byte_mutations import mutate_bytes
from reliability.loading import PLAIN, WrongLoadError, make_trap, try_mutants
from reliability.row import Row
from reliability.tree_mutations import mutate_yaml
from shoecal_core.recording.session import FILE, ROBOT, SHOE, URDF, Session

Rng = np.random.Generator
NAMES = (FILE, ROBOT, SHOE, URDF, "run_001.mcap", "run_002.mcap")


def target(folder: Path) -> SessionFolder:
    """One session."""
    return SessionFolder(folder)


class SessionFolder:
    """A session that is laid anew for every mutant."""

    codes = PLAIN | {"field", "version", "session", "recording", "damaged", "hash-mismatch"}

    def __init__(self, folder: Path) -> None:
        self._trap = make_trap(folder)
        self._folder, self._whole = folder / "session", folder / "whole"
        for place in (self._folder, self._whole):
            shutil.rmtree(place, ignore_errors=True)
        originals.session(self._whole, runs=2)
        shutil.copytree(self._whole, self._folder)

    def mutate(self, rng: Rng) -> str:
        shutil.rmtree(self._folder)
        shutil.copytree(self._whole, self._folder)
        if rng.random() < 0.7:
            path = self._folder / FILE
            what, mutant = mutate_yaml(path.read_bytes(), rng, self._folder.parent)
            path.write_bytes(mutant)
            return f"{FILE}: {what}"
        return self._rearrange(rng)

    def load(self) -> None:
        session = Session.open(self._folder)
        entries = session.runs
        _ = session.missing, session.unfinished
        session.check_hashes()
        for entry in entries:
            run = session.read(entry.run)
            rows = np.rint((run.start_ns - originals.START_NS) / originals.STEP_NS + np.arange(40))
            wanted = np.stack([originals.volts(int(row)) for row in rows])
            if not np.array_equal(run.readings.value, wanted):
                raise WrongLoadError(f"{entry.path.name}: other readings than were recorded")

    def _rearrange(self, rng: Rng) -> str:
        """Do something to the folder's files."""
        name, other = rng.choice(NAMES, size=2, replace=False)
        path, elsewhere = self._folder / str(name), self._folder / str(other)
        kind = int(rng.integers(9))
        told = (
            "gone", "empty", "a folder", "a pipe", "a link to nothing", "a link to itself",
            f"what {other} was", "altered", "renamed",
        )[kind]  # fmt: skip
        whole = path.read_bytes()
        path.unlink()
        if kind == 1:
            path.touch()
        elif kind == 2:
            path.mkdir()
        elif kind == 3:
            os.mkfifo(path)
        elif kind in (4, 5):
            path.symlink_to("nowhere" if kind == 4 else path.name)
        elif kind == 6:
            shutil.copy(elsewhere, path)
        elif kind == 7:
            path.write_bytes(mutate_bytes(whole, rng)[1])
        elif kind == 8:
            names = (
                "run_1.mcap", "run_007.mcap", "run_000.mcap", "run_001.mcap.part",
                "run_٠٠١.mcap", f"run_{'9' * 200}.mcap", "session.yml",
            )  # fmt: skip
            (self._folder / names[int(rng.integers(len(names)))]).write_bytes(whole)
        return f"{name}: {told}"


ROW = Row(
    key="mutants-session",
    fault="mutated session: session.yaml and the files of the folder",
    holds="refused with one line that names the file, or read as it was recorded; at most 2 GiB "
    "and 10 s of the processor",
    tries=10_000,
    step=500,
    run=partial(try_mutants, "mutated_sessions"),
)
