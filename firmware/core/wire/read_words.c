// SPDX-License-Identifier: MIT
#include "wire/read_words.h"

#include "build_features.h"   // SEVERAL_AXES
#include "wire/bytes.h"       // put_word
#include "wire/server_data.h" // data_*

// Read what is quicker as a whole. Returns the number of registers, 0: none is.
static inline uint8_t read_several(uint8_t *to,
                                   uint16_t address,
                                   uint8_t count,
                                   bool inputs)
{
    return SEVERAL_AXES && inputs ? data_inputs(address, count, to) : 0;
}

uint8_t *read_words(uint8_t *to, uint16_t address, uint8_t count, bool inputs)
{
    while (count != 0) {
        uint8_t read = read_several(to, address, count, inputs);
        if (read == 0) {
            put_word(to, inputs ? data_input(address) : data_holding(address));
            read = 1;
        }
        to += (uint8_t)(2u * read);
        address = (uint16_t)(address + read);
        count = (uint8_t)(count - read);
    }
    return to;
}
