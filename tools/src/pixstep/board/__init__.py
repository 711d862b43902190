# SPDX-License-Identifier: MIT
"""A board from the host: its registers, its pins, a client over Modbus."""
