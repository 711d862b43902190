// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "stack.h"

#include <fcntl.h>
#include <gelf.h>
#include <string.h>
#include <unistd.h>

#define PAINT           0xA5U
#define DATA_SPACE      0x800000U // where the linker puts RAM in an AVR's ELF file
#define DATA_SPACE_MASK 0xFFFFU

// The linker's name for the first address after .noinit.
static const char end_symbol[] = "_end";

static bool find_in_section(Elf *elf, Elf_Scn *section, uint16_t *address)
{
    GElf_Shdr header;
    Elf_Data *data;

    if (gelf_getshdr(section, &header) == NULL || header.sh_type != SHT_SYMTAB ||
        header.sh_entsize == 0) {
        return false;
    }
    data = elf_getdata(section, NULL);
    for (int i = 0; data != NULL && i < (int)(header.sh_size / header.sh_entsize); i++) {
        GElf_Sym symbol;
        const char *name;

        if (gelf_getsym(data, i, &symbol) == NULL) {
            continue;
        }
        name = elf_strptr(elf, header.sh_link, symbol.st_name);
        if (name != NULL && strcmp(name, end_symbol) == 0) {
            *address = (uint16_t)(symbol.st_value & DATA_SPACE_MASK);
            return symbol.st_value >= DATA_SPACE;
        }
    }
    return false;
}

static bool find_in_elf(Elf *elf, uint16_t *address)
{
    Elf_Scn *section = NULL;

    while ((section = elf_nextscn(elf, section)) != NULL) {
        if (find_in_section(elf, section, address)) {
            return true;
        }
    }
    return false;
}

bool stack_find(struct stack_watch *watch, const char *elf_path, const avr_t *avr)
{
    int file = open(elf_path, O_RDONLY);
    bool found = false;
    Elf *elf;

    watch->top = avr->ramend;
    watch->bottom = watch->top;
    if (file < 0) {
        return false;
    }
    (void)elf_version(EV_CURRENT);
    elf = elf_begin(file, ELF_C_READ, NULL);
    if (elf != NULL) {
        found = find_in_elf(elf, &watch->bottom);
        (void)elf_end(elf);
    }
    (void)close(file);
    return found;
}

void stack_paint(const struct stack_watch *watch, avr_t *avr)
{
    memset(
        &avr->data[watch->bottom], (int)PAINT, (size_t)(watch->top - watch->bottom) + 1);
}

uint32_t stack_free_bytes(const struct stack_watch *watch, const avr_t *avr)
{
    uint32_t address = watch->bottom;

    while (address <= watch->top && avr->data[address] == PAINT) {
        address++;
    }
    return address - watch->bottom;
}

uint32_t stack_used_bytes(const struct stack_watch *watch, const avr_t *avr)
{
    return (uint32_t)(watch->top + 1 - watch->bottom) - stack_free_bytes(watch, avr);
}
