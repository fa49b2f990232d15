"""Linear algebra on one thread, for programs that import this before numpy is loaded.

Matrices here are small: more threads wait for each other most of the time, and on a busy computer
make a diagnosis ten times slower. Variables that are already set stay as they are.
"""

from __future__ import annotations

import os

for _library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
