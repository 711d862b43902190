# SPDX-License-Identifier: MIT
"""Operations: tables of two axes."""
