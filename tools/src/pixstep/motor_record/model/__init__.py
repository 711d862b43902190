# SPDX-License-Identifier: MIT
"""How the record behaves: one module for each idea, `record` is what others use."""
