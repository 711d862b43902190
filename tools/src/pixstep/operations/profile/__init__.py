# SPDX-License-Identifier: MIT
"""Operations with acceleration profiles."""
