# SPDX-License-Identifier: MIT
"""Writes the C source of the Python extension `_core` by cffi: core.h as Python sees it.

binding.py OUTPUT.c
"""

import sys

from cffi import FFI

# What core.h and the headers that it includes declare; the C compiler compares the two.
DECLARATIONS = """
struct line_limits {
    uint32_t pixel_ticks;
    uint16_t min_interval_ticks;
    uint16_t smooth_min_interval_ticks;
    uint16_t seek_min_interval_ticks;
    uint16_t reversal_min_ticks;
    uint16_t max_acceleration;
    uint16_t start_stop_steps;
};
struct segment { int16_t count; uint16_t repeat; };
struct core_finding { uint32_t code; uint32_t pixel; };
struct plan;

uint32_t core_check(const struct line_limits *limits, const struct segment *entries,
                    uint32_t entry_count, struct core_finding *found, uint32_t room);
struct plan *plan_begin(uint32_t timer_hz, uint32_t hz_num, uint32_t hz_den,
                        const struct line_limits *limits, const struct segment *entries,
                        uint32_t entry_count, bool pixels);
int32_t plan_rows(struct plan *plan, int64_t *values, uint32_t room);
void plan_end(struct plan *plan);
"""


def main() -> None:
    """Write the source."""
    binding = FFI()
    binding.cdef(DECLARATIONS)
    binding.set_source("_core", '#include "core.h"')
    binding.emit_c_code(sys.argv[1])


if __name__ == "__main__":
    main()
