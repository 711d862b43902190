# SPDX-License-Identifier: MIT
"""Operations with files of all formats."""
