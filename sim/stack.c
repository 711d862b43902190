// SPDX-License-Identifier: MIT

#include "stack.h"

#include <string.h>

#define PAINT 0xA5U
// The firmware writes its canary into the lowest word of the stack's room at reset.
#define CANARY_BYTES 2U

// The linker's name for the first address after .noinit.
static const char end_symbol[] = "_end";

static uint32_t room_bytes(const struct stack_watch *watch)
{
    return (uint32_t)watch->top + 1U - watch->bottom;
}

bool stack_find(struct stack_watch *watch,
                const struct symbols *symbols,
                const avr_t *avr)
{
    bool several;
    const struct symbol *end = symbols_find(symbols, end_symbol, &several);

    watch->bottom = watch->top = avr->ramend;
    if (end == NULL || end->space != SYMBOL_RAM || end->address > avr->ramend ||
        avr->ramend - end->address >= STACK_BYTES_MOST) {
        return false;
    }
    watch->bottom = (uint16_t)(end->address + CANARY_BYTES);
    watch->free_least = room_bytes(watch);
    return true;
}

void stack_paint(struct stack_watch *watch, avr_t *avr)
{
    memset(watch->paint, (int)PAINT, sizeof watch->paint);
    memcpy(&avr->data[watch->bottom], watch->paint, room_bytes(watch));
}

void stack_before_noise(struct stack_watch *watch, const avr_t *avr)
{
    watch->free_least = stack_free_bytes(watch, avr);
}

void stack_after_noise(struct stack_watch *watch, const avr_t *avr)
{
    memcpy(watch->paint, &avr->data[watch->bottom], room_bytes(watch));
}

uint32_t stack_free_bytes(const struct stack_watch *watch, const avr_t *avr)
{
    uint32_t count = 0;

    while (count < watch->free_least &&
           avr->data[watch->bottom + count] == watch->paint[count]) {
        count++;
    }
    return count;
}

uint32_t stack_used_bytes(const struct stack_watch *watch, const avr_t *avr)
{
    return room_bytes(watch) - stack_free_bytes(watch, avr);
}
