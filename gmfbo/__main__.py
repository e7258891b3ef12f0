"""`python -m gmfbo` is the `gmfbo` program."""

import sys

from gmfbo.cli import main

if __name__ == "__main__":
    sys.exit(main())
