# SPDX-License-Identifier: MIT
"""Operations: moves and homing."""
