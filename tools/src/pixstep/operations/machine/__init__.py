# SPDX-License-Identifier: MIT
"""Operations: machine files."""
