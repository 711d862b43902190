// SPDX-License-Identifier: MIT

#include "symbols.h"

#include <fcntl.h>
#include <gelf.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "grow.h"

// Where the linker puts RAM and EEPROM in an AVR's ELF file.
#define RAM_SPACE    0x800000U
#define EEPROM_SPACE 0x810000U
#define FIRST_ROOM   256U

static enum symbol_space space_of(uint64_t value)
{
    if (value >= EEPROM_SPACE) {
        return SYMBOL_EEPROM;
    }
    return (value >= RAM_SPACE) ? SYMBOL_RAM : SYMBOL_FLASH;
}

static uint32_t address_of(uint64_t value)
{
    switch (space_of(value)) {
    case SYMBOL_EEPROM:
        return (uint32_t)(value - EEPROM_SPACE);
    case SYMBOL_RAM:
        return (uint32_t)(value - RAM_SPACE);
    case SYMBOL_FLASH:
    default:
        return (uint32_t)value;
    }
}

static bool is_place(const GElf_Sym *symbol)
{
    int type = GELF_ST_TYPE(symbol->st_info);

    return symbol->st_shndx != SHN_UNDEF &&
           (type == STT_NOTYPE || type == STT_OBJECT || type == STT_FUNC);
}

static void add_symbol(struct symbols *s, const char *name, const GElf_Sym *symbol)
{
    if (name == NULL || name[0] == '\0' || !is_place(symbol)) {
        return;
    }
    if (s->count == s->room) {
        s->list = grow(s->list, &s->room, FIRST_ROOM, sizeof *s->list);
    }
    s->list[s->count] = (struct symbol){
        .name = strdup(name),
        .space = space_of(symbol->st_value),
        .address = address_of(symbol->st_value),
        .size = (uint32_t)symbol->st_size,
    };
    s->count += (s->list[s->count].name != NULL) ? 1 : 0;
}

static void read_section(struct symbols *s, Elf *elf, Elf_Scn *section)
{
    GElf_Shdr header;
    Elf_Data *data;

    if (gelf_getshdr(section, &header) == NULL || header.sh_type != SHT_SYMTAB ||
        header.sh_entsize == 0) {
        return;
    }
    data = elf_getdata(section, NULL);
    for (int i = 0; data != NULL && i < (int)(header.sh_size / header.sh_entsize); i++) {
        GElf_Sym symbol;

        if (gelf_getsym(data, i, &symbol) != NULL) {
            add_symbol(s, elf_strptr(elf, header.sh_link, symbol.st_name), &symbol);
        }
    }
}

bool symbols_read(struct symbols *s, const char *elf_path)
{
    int file = open(elf_path, O_RDONLY);
    Elf_Scn *section = NULL;
    Elf *elf;

    memset(s, 0, sizeof *s);
    if (file < 0) {
        return false;
    }
    (void)elf_version(EV_CURRENT);
    elf = elf_begin(file, ELF_C_READ, NULL);
    while (elf != NULL && (section = elf_nextscn(elf, section)) != NULL) {
        read_section(s, elf, section);
    }
    (void)elf_end(elf);
    (void)close(file);
    return s->count > 0;
}

static bool same_place(const struct symbol *a, const struct symbol *b)
{
    return a->space == b->space && a->address == b->address;
}

// With a suffix: the names that continue with a dot after `name`.
static const struct symbol *find_unique(const struct symbols *s,
                                        const char *name,
                                        bool with_suffix,
                                        bool *several)
{
    size_t length = strlen(name);
    const struct symbol *found = NULL;

    for (size_t i = 0; i < s->count; i++) {
        const struct symbol *one = &s->list[i];

        if (strncmp(one->name, name, length) != 0 ||
            one->name[length] != (with_suffix ? '.' : '\0')) {
            continue;
        }
        if (found != NULL && !same_place(found, one)) {
            *several = true;
            return NULL;
        }
        found = one;
    }
    return found;
}

const struct symbol *symbols_find(const struct symbols *s,
                                  const char *name,
                                  bool *several)
{
    const struct symbol *found;

    *several = false;
    found = find_unique(s, name, false, several);
    return (found != NULL || *several) ? found : find_unique(s, name, true, several);
}

const char *symbol_space_name(enum symbol_space space)
{
    switch (space) {
    case SYMBOL_RAM:
        return "ram";
    case SYMBOL_EEPROM:
        return "eeprom";
    case SYMBOL_FLASH:
    default:
        return "flash";
    }
}

void symbols_free(struct symbols *s)
{
    for (size_t i = 0; i < s->count; i++) {
        free(s->list[i].name);
    }
    free(s->list);
    memset(s, 0, sizeof *s);
}
