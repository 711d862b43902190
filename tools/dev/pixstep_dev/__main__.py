# SPDX-License-Identifier: MIT
"""`python -m pixstep_dev` is the same as the `pixstep-dev` command."""

import sys

from pixstep import signals

if __name__ == "__main__":
    try:
        signals.catch()
        from pixstep_dev.cli.main import main
    except KeyboardInterrupt as error:  # loading takes a moment; the command is not there yet
        print(f"pixstep-dev: ended by {signals.name(error)}", file=sys.stderr)
        sys.exit(signals.status(error))
    main(prog_name="pixstep-dev")
