# SPDX-License-Identifier: MIT
"""What the firmware promises, where more than one test holds it to that."""

# From the emergency stop to the permit: confirmation of the input, what keeps its interrupt
# waiting, and halting the axes one by one. 150 us at 16 MHz; seen: 750 on the Uno, 1734 on the Mega
# where four axes turn at once.
ESTOP_CYCLES = 2400
