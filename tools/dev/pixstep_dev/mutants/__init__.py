# SPDX-License-Identifier: MIT
"""Small changes of the firmware, one at a time, that the tests must see."""
