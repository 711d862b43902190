// SPDX-License-Identifier: MIT
// Executes accesses that the test has written into the RAM at SCRIPT, four bytes each: what,
// address (two bytes), value. What is read goes to RESULT[0], RESULT[1], ...; the script's end to
// RESULT[62]; RESULT[63] counts the interrupts of whatever vector. The fifth one returns with
// interrupts off, so that a request that goes on ends.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define SCRIPT ((const volatile uint8_t *)0x400)

enum {
    END = 0,
    WRITE = 1,
    READ = 2,
    DELAY = 3, // so many times 16 cycles, once at least, the count in the address's place
    AFTER =
        4, // writes, and with the next entry reads so many cycles after the write: `value` + 4
    TWICE = 5, // writes, and at once the value of the next entry
};

#define MOST_INTERRUPTS "5"
#define COUNT_AT        "0x67e"

ISR(BADISR_vect, ISR_NAKED)
{
    __asm__ volatile("push r24\n\t"
                     "in r24, %[sreg]\n\t"
                     "push r24\n\t"
                     "lds r24, " COUNT_AT "\n\t"
                     "inc r24\n\t"
                     "sts " COUNT_AT ", r24\n\t"
                     "cpi r24, " MOST_INTERRUPTS "\n\t"
                     "brsh 1f\n\t"
                     "pop r24\n\t"
                     "out %[sreg], r24\n\t"
                     "pop r24\n\t"
                     "reti\n"
                     "1:\n\t"
                     "pop r24\n\t"
                     "out %[sreg], r24\n\t"
                     "pop r24\n\t"
                     "ret\n\t" ::[sreg] "I"(_SFR_IO_ADDR(SREG)));
}

static volatile uint8_t *address_at(const volatile uint8_t *entry)
{
    return (volatile uint8_t *)(uintptr_t)(entry[1] | (uint16_t)(entry[2] << 8));
}

static void delay(uint16_t turns)
{
    __asm__ volatile("1:\n\t"
                     ".rept 12\n\tnop\n\t.endr\n\t"
                     "sbiw %[turns], 1\n\t"
                     "brne 1b\n\t"
                     : [turns] "+w"(turns));
}

// Writes, jumps past some of 256 nops, and reads.
static uint8_t read_after(volatile uint8_t *to,
                          uint8_t value,
                          volatile uint8_t *from,
                          uint8_t nops)
{
    uint8_t seen;

    __asm__ volatile("ldi r30, lo8(pm(2f))\n\t"
                     "ldi r31, hi8(pm(2f))\n\t"
                     "sub r30, %[nops]\n\t"
                     "sbc r31, r1\n\t"
                     "st X, %[value]\n\t"
                     "ijmp\n\t"
                     ".rept 256\n\tnop\n\t.endr\n"
                     "2:\n\t"
                     "ld %[seen], %a[from]\n\t"
                     : [seen] "=&r"(seen)
                     : [nops] "r"(nops), [value] "r"(value), "x"(to), [from] "b"(from)
                     : "r30", "r31");
    return seen;
}

int main(void)
{
    const volatile uint8_t *entry = SCRIPT;
    uint8_t results = 0;

    for (;;) {
        switch (entry[0]) {
        case WRITE:
            *address_at(entry) = entry[3];
            break;
        case READ:
            RESULT[results++] = *address_at(entry);
            break;
        case DELAY:
            delay((uint16_t)(entry[1] | entry[2] << 8));
            break;
        case AFTER:
            RESULT[results++] =
                read_after(address_at(entry), entry[3], address_at(entry + 4), entry[7]);
            entry += 4;
            break;
        case TWICE:
            __asm__ volatile(
                "st X, %[first]\n\tst X, %[second]"
                :
                : "x"(address_at(entry)), [first] "r"(entry[3]), [second] "r"(entry[7])
                : "memory");
            entry += 4;
            break;
        case END:
        default:
            RESULT[62] = 0x600D;
            for (;;) {
            }
        }
        entry += 4;
    }
}
