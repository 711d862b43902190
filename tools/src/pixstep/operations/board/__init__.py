# SPDX-License-Identifier: MIT
"""Operations with boards on a bus."""
