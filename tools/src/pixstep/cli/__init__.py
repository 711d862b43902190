# SPDX-License-Identifier: MIT
"""The `pixstep` command, a module for each group of commands; `main` puts them together."""
