"""out/bench.json: what `make bench` has measured, one key a benchmark."""

from __future__ import annotations

import fcntl
import json
from collections.abc import Mapping
from pathlib import Path

from shoecal_core.files import atomic_write

PATH = Path(__file__).resolve().parents[1] / "out" / "bench.json"


def record(key: str, value: Mapping[str, object], path: Path = PATH) -> None:
    """Write one benchmark's figures, keeping the others', also while another one writes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        known = json.loads(path.read_text()) if path.is_file() else {}
        known[key] = dict(value)
        atomic_write(path, json.dumps(known, indent=1, sort_keys=True, allow_nan=False) + "\n")
