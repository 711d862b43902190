# SPDX-License-Identifier: MIT
"""Operations with line files."""
