# SPDX-License-Identifier: MIT
"""Random valid lines, and campaigns of them on simulated boards."""
