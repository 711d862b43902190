// SPDX-License-Identifier: MIT
//
// The symbols of an image by name: the functions, variables and linker's marks of its ELF file.
// The AVR has three address spaces; avr-gcc's linker tells them apart by offsets in the ELF file,
// which this module removes.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum symbol_space { SYMBOL_FLASH, SYMBOL_RAM, SYMBOL_EEPROM };

struct symbol {
    char *name; // of the list's own memory
    enum symbol_space space;
    uint32_t address; // bytes from the start of its space
    uint32_t size;    // bytes, 0 if the file does not give it
};

struct symbols {
    struct symbol *list;
    size_t count; // symbols in the list
    size_t room;  // for so many
};

// Reads all symbols of a file. False if it has none or cannot be read. Free them in either case.
bool symbols_read(struct symbols *symbols, const char *elf_path);

// The symbol of this name, or else the only one whose name is this and a suffix of the compiler's
// ("name.lto_priv.0"). NULL if there is none, or if several of that name are at different addresses
// (*several).
const struct symbol *symbols_find(const struct symbols *symbols,
                                  const char *name,
                                  bool *several);

// "flash", "ram" or "eeprom".
const char *symbol_space_name(enum symbol_space space);

// Frees the list; it is then empty.
void symbols_free(struct symbols *symbols);
