// SPDX-License-Identifier: MIT
//
// Arrays that grow.
#pragma once

#include <stddef.h>

// Doubles the room of an array (NULL while *room is 0: `first` elements then) of elements of `size`
// bytes. Returns the array at its new place; *room is the new number of elements. Prints one line
// and aborts if there is no memory.
void *grow(void *array, size_t *room, size_t first, size_t size);
