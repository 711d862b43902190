# SPDX-License-Identifier: MIT
"""The tutorial as a tested document: its commands are run and compared with what it shows."""
