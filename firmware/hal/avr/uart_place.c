// SPDX-License-Identifier: MIT
#include "hal/avr/uart_place.h"

struct uart_place uart_place;
