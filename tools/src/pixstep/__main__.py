# SPDX-License-Identifier: MIT
"""The `pixstep` command; `python -m pixstep` is the same."""

import sys

from pixstep import signals


def run() -> None:
    """Load the command and run it; what ends the loading is one line."""
    try:
        signals.catch()
        from pixstep.cli.main import main
    except KeyboardInterrupt as error:  # loading takes a moment; the command is not there yet
        print(f"pixstep: ended by {signals.name(error)}", file=sys.stderr)
        sys.exit(signals.status(error))
    try:
        main(prog_name="pixstep")
    finally:
        signals.leave()


if __name__ == "__main__":
    run()
