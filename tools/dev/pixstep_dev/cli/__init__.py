# SPDX-License-Identifier: MIT
"""The `pixstep-dev` command, a module for each group of commands; `main` puts them together."""
