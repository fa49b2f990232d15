"""`python -m shoecal_core.cli`: the same as the installed `shoecal`."""

import sys

from shoecal_core.cli.program import main

if __name__ == "__main__":
    sys.exit(main())
