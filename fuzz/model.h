// SPDX-License-Identifier: MIT
// A small world behind the server: registers that end where addresses end, so that arithmetic that
// wraps is seen, and values that a write refuses in each of the ways that there are.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define MODEL_WORDS 160u // from address 0 on, and
#define MODEL_TAIL  16u  //   as the last ones before 0xFFFF

// Words that make a whole write fail, the first of them in a request decides.
#define MODEL_ILLEGAL 0x0BADu
#define MODEL_BUSY    0x0B06u
#define MODEL_FAILS   0x0D04u

struct model {
    uint16_t words[MODEL_WORDS + MODEL_TAIL];
};

extern struct model model; // what data_*() read and write

void model_reset(void);

bool model_mapped(uint16_t address, uint16_t count);
uint16_t model_input(uint16_t address);
uint16_t model_holding(const struct model *at, uint16_t address);

// 0, or the exception that the words deserve; then nothing is written. Words as big-endian bytes.
uint8_t model_write(struct model *at,
                    uint16_t address,
                    uint16_t count,
                    const uint8_t *words);
