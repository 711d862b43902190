// SPDX-License-Identifier: MIT
#include "avr/hal/uart_place.h"

struct uart_place uart_place;
