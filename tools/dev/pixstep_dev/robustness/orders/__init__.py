# SPDX-License-Identifier: MIT
"""Commands in every order and at any cycle, against a small model of what must hold."""
