// SPDX-License-Identifier: MIT

#include "eeprom_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define PATH_MOST 4096

// False if the file is longer than the EEPROM.
static bool read_bytes(struct eeprom *e, FILE *file)
{
    uint8_t bytes[EEPROM_BYTES_MOST + 1];
    size_t count = fread(bytes, 1, (size_t)e->size + 1, file);

    if (count > e->size) {
        return false;
    }
    memset(e->bytes, (int)EEPROM_ERASED, sizeof e->bytes);
    memcpy(e->bytes, bytes, count);
    return true;
}

// Whether the file can be created, asked before a long run rather than at its end. Sets errno if it
// cannot.
static bool may_create(const char *path)
{
    const char *slash = strrchr(path, '/');
    char folder[PATH_MOST];
    size_t length = (slash != NULL) ? (size_t)(slash - path) + 1 : 0;

    if (length == 0) {
        return access(".", W_OK) == 0;
    }
    if (length >= sizeof folder) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(folder, path, length);
    folder[length] = '\0';
    return access(folder, W_OK) == 0;
}

bool eeprom_load(struct eeprom *e, const char *path, char *error, size_t room)
{
    FILE *file = fopen(path, "rb");
    bool fits;

    if (file == NULL && errno == ENOENT && may_create(path)) {
        return true; // erased, as a new part
    }
    if (file == NULL) {
        (void)snprintf(error, room, "%s: %s", path, strerror(errno));
        return false;
    }
    errno = 0;
    fits = read_bytes(e, file);
    if (ferror(file) != 0) {
        (void)snprintf(error, room, "%s: %s", path, strerror(errno));
        fits = false;
    } else if (!fits) {
        (void)snprintf(error, room, "%s: more than %u bytes", path, (unsigned)e->size);
    }
    (void)fclose(file);
    return fits;
}

bool eeprom_save(const struct eeprom *e, const char *path)
{
    char part[PATH_MOST];
    FILE *file;
    bool fine;

    if (snprintf(part, sizeof part, "%s.part", path) >= (int)sizeof part) {
        errno = ENAMETOOLONG;
        return false;
    }
    file = fopen(part, "wb");
    if (file == NULL) {
        return false;
    }
    fine = fwrite(e->bytes, 1, e->size, file) == e->size;
    fine = fclose(file) == 0 && fine;
    if (fine && rename(part, path) == 0) {
        return true;
    }
    (void)unlink(part);
    return false;
}
