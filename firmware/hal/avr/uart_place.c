// SPDX-License-Identifier: MIT
#include "hal/avr/uart_place.h"

#include <stddef.h> // offsetof

_Static_assert(offsetof(struct uart_place, first_byte) == UART_FIRST &&
                   offsetof(struct uart_place, next_byte) == UART_NEXT &&
                   offsetof(struct uart_place, end_byte) == UART_END &&
                   offsetof(struct uart_place, first_silence) == UART_SILENCE &&
                   offsetof(struct uart_place, overruns) == UART_OVERRUNS &&
                   offsetof(struct uart_place, control_after) == UART_CONTROL,
               "known to uart_receive.S");

struct uart_place uart_place;
