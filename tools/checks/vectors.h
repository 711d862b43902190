// SPDX-License-Identifier: MIT
// Read by boards.py for the vector numbers of a part.
#include <avr/io.h>
