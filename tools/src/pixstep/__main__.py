# SPDX-License-Identifier: MIT
"""`python -m pixstep` is the same as the `pixstep` command."""

from pixstep.cli.main import main

if __name__ == "__main__":
    main(prog_name="pixstep")
