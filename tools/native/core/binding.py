# SPDX-License-Identifier: MIT
"""Writes the C source of the Python extension `_core` by cffi: core.h, law.h and
guarantee.h as Python sees them.

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
struct guarantee_costs {
    double call;
    double even_px, even_step, even_changed, even_begun;
    double train_px, train_step;
    double single_px, single_step;
    double curved_px, curved_start, curved_step;
    double piece_px, piece_step, curve_px;
    double piece_more;
    double shifted_px;
    double turned_px;
    double crawl_px;
    double flat_step, wide_step, steep_step, slow_step;
    double moved_tick, wide_moved_tick, missed_tick, short_batch;
    double zero_px, pump;
    double locked_px;
    double early;
    double account, account_px, account_entry, account_long_entry;
    double account_curve_px, account_piece_px, account_train_px;
    double edge, round, edge_locked, round_locked;
    double edge_few;
    double round_unlike;
    double turn;
    double request;
    double request_byte;
    double step_isr, train_isr, edge_isr, byte_isr, other_isr_share;
};
struct guarantee_axis {
    const struct segment *entries;
    uint32_t count;
    bool smooth;
    uint16_t backlash_steps;
    uint16_t line_speed;
};
struct guarantee_board {
    uint32_t axes;
    bool short_curves;
    double pixel_ticks;
    uint32_t divider;
    uint32_t lead_edges;
    uint32_t more_edges;
    double bytes_per_tick, asked_per_tick;
    double round_ticks;
    uint32_t most_calls;
    double spare_ticks;
    double margin;
};
struct guarantee_verdict {
    bool follows;
    uint32_t axis;
    uint32_t pixel;
    double late_ticks;
    double slack_ticks;
    double busy;
};
void guarantee_demand(const struct guarantee_costs *costs,
                      const struct guarantee_board *board,
                      const struct guarantee_axis *line,
                      double *decode,
                      double *account);
void guarantee_judge(const struct guarantee_costs *costs,
                     const struct guarantee_board *board,
                     const struct guarantee_axis *line,
                     uint32_t lines,
                     struct guarantee_verdict *verdict);
"""


def main() -> None:
    """Write the source."""
    binding = FFI()
    binding.cdef(DECLARATIONS)
    binding.set_source("_core", '#include "core.h"\n#include "law.h"\n#include "guarantee.h"')
    binding.emit_c_code(sys.argv[1])


if __name__ == "__main__":
    main()
