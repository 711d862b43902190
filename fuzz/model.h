// SPDX-License-Identifier: MIT
// A small world behind the server: data that ends where addresses end, so that arithmetic that
// wraps is seen, and values that a write refuses in each of the ways that there are.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define MODEL_WORDS  160u   // holding registers from address 0 on
#define MODEL_INPUTS 0x180u // input registers from address 0 on
#define MODEL_BITS   200u   // coils, and discrete inputs, from address 0 on
#define MODEL_TAIL   16u    // and of each the last ones before 0xFFFF

// Words that make a whole write fail, the first of them in a request decides.
#define MODEL_ILLEGAL 0x0BADu
#define MODEL_BUSY    0x0B06u
#define MODEL_FAILS   0x0D04u
// Coils that fail when they are to be on.
#define MODEL_STUCK_COIL 13u

#define MODEL_IDENTITY  "maker thing 1.0"
#define MODEL_SERVER_ID 42u

struct model {
    uint16_t words[MODEL_WORDS + MODEL_TAIL];
    bool coils[MODEL_BITS + MODEL_TAIL];
    bool listen_only;
};

extern struct model model; // what data_*() read and write

void model_reset(void);
bool model_same(const struct model *one, const struct model *other);

bool model_mapped(uint32_t from_start, uint16_t address, uint16_t count);
uint16_t model_input(uint16_t address);
uint16_t model_holding(const struct model *at, uint16_t address);
bool model_coil(const struct model *at, uint16_t address);
bool model_discrete(uint16_t address);

// 0, or the exception that the data deserve; then nothing is written. Words as big-endian bytes;
// bit 0 of the first byte is the first coil.
uint8_t model_write(struct model *at,
                    uint16_t address,
                    uint16_t count,
                    const uint8_t *words);
uint8_t model_write_coils(struct model *at,
                          uint16_t address,
                          uint16_t count,
                          const uint8_t *bits);
