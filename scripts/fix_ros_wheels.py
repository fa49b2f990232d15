"""Let the CMake files of the ROS 2 wheels name this machine's Python and numpy headers.

The wheels export the header folders of the machine that built them; no interface package
builds against those. Run by `setup.sh` with the interpreter of the environment to mend; a
second run changes nothing.
"""

from __future__ import annotations

import re
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

BUILD_MACHINE = r"/opt/python/cp\d+-cp\d+t?"
PYTHON_HEADERS = re.compile(BUILD_MACHINE + r"/include/python3\.\d+t?")
NUMPY_HEADERS = re.compile(
    BUILD_MACHINE + r"/lib/python3\.\d+t?/site-packages/numpy/(?:_core|core)/include"
)


def fix(share: Path, headers: Mapping[re.Pattern[str], str]) -> int:
    """Replace each pattern by its folder in all CMake files under `share`; files changed."""
    changed = 0
    for file in share.glob("*/cmake/*.cmake"):
        before = file.read_text(encoding="utf-8")
        after = before
        for pattern, folder in headers.items():
            after = folder.join(pattern.split(after))
        if after != before:
            file.write_text(after, encoding="utf-8")
            changed += 1
    return changed


if __name__ == "__main__":
    import numpy as np

    fix(
        Path(sys.prefix, "share"),
        {PYTHON_HEADERS: sysconfig.get_path("include"), NUMPY_HEADERS: np.get_include()},
    )
