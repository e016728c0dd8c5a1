"""Starts the program `afterimage`, which lies beside the module with the libraries that both use."""

import os
import pathlib
import sys


def main() -> None:
    """Becomes the program, with the arguments of this process."""
    program = pathlib.Path(__file__).parent / "bin" / "afterimage"
    try:
        os.execv(program, ["afterimage", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"afterimage: {program} does not start: {error.strerror}. Install the package again")
