# SPDX-License-Identifier: MIT
"""`python -m pixstep` is the same as the `pixstep` command."""

import sys

if __name__ == "__main__":
    try:
        from pixstep.cli.main import main
    except KeyboardInterrupt:  # loading takes a moment; click is not there yet to say it
        sys.exit("Aborted!")
    main(prog_name="pixstep")
