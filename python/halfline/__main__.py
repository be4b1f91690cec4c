"""The command ``halfline``, by ``python -m halfline``."""

import sys

from ._command import main

sys.exit(main())
