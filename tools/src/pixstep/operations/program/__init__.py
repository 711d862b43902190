# SPDX-License-Identifier: MIT
"""Operations: motion programs."""
