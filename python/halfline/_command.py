"""The command ``halfline`` of the wheel."""

import sys

from halfline import _halfline


def main() -> int:
    """Runs the command with the arguments of this process; the exit code is the command's."""
    return _halfline.command(sys.argv[1:])
