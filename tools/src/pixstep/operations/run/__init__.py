# SPDX-License-Identifier: MIT
"""Operations: simulated runs of lines."""
