# SPDX-License-Identifier: MIT
"""The tables of the record's fields, by what they are for."""
