"""The command ``halfline`` of the wheel."""

import signal
import sys

from halfline import _halfline


def main() -> int:
    """Runs the command with the arguments of this process; the exit code is the command's."""
    # The command handles ctrl-C itself; Python's handler would raise KeyboardInterrupt after it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _halfline.command(sys.argv[1:])
