# SPDX-License-Identifier: MIT
"""Writes the C source of the Python extension `_core` by cffi: core.h and law.h as Python
sees them.

binding.py OUTPUT.c
"""

import sys

from cffi import FFI

# What these headers and those that they include declare; the C compiler compares the two.
DECLARATIONS = """
struct line_limits {
    uint32_t pixel_ticks;
    uint16_t min_interval_ticks;
    uint16_t smooth_min_interval_ticks;
    uint16_t seek_min_interval_ticks;
    uint16_t reversal_min_ticks;
    uint16_t max_acceleration;
    uint16_t start_stop_steps;
    uint16_t divider;
};
struct segment { int16_t count; uint16_t repeat; };
struct core_finding { uint32_t code; uint32_t pixel; };
struct checker;
struct plan;

struct checker *checker_begin(const struct line_limits *limits);
uint32_t checker_more(struct checker *checker, const struct segment *entries,
                      uint32_t entry_count, struct core_finding *found, uint32_t room);
void checker_end(struct checker *checker);
struct plan *plan_begin(uint32_t timer_hz, uint32_t hz_num, uint32_t hz_den,
                        const struct line_limits *limits, const struct segment *entries,
                        uint32_t entry_count, bool pixels);
int32_t plan_rows(struct plan *plan, int64_t *values, uint32_t room);
bool plan_over(const struct plan *plan);
void plan_end(struct plan *plan);

struct law {
    uint32_t count;
    uint32_t bounds;
    uint32_t motors;
    const double *a;
    const double *b;
    const double *most;
    const double *cap;
    const double *end_cap;
    const uint8_t *rest;
};

void law_caps(const struct law *law, double *cap);
double law_backward(const struct law *law, double end, double *highest);
double law_forward(const struct law *law, const double *highest, double following, double w,
                   double *begin, double *end);
"""


def main() -> None:
    """Write the source."""
    binding = FFI()
    binding.cdef(DECLARATIONS)
    binding.set_source("_core", '#include "core.h"\n#include "law.h"')
    binding.emit_c_code(sys.argv[1])


if __name__ == "__main__":
    main()
