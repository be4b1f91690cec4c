"""The command ``halfline``, by ``python -m halfline``."""

import sys

from ._command import main

if __name__ == "__main__":
    sys.exit(main())
