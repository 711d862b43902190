// SPDX-License-Identifier: MIT

#include "stats.h"

#include <inttypes.h>
#include <time.h>

#include "cpu_clock.h"

// CPU time of this process so far, in seconds.
static double cpu_s(void)
{
    struct timespec used;

    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return (double)used.tv_sec + (double)used.tv_nsec * 1e-9;
}

static void write_handlers(FILE *out, const struct irq_stats *s)
{
    const char *comma = "";

    for (int i = 0; i < IRQ_VECTORS; i++) {
        const struct irq_vector_stats *v = &s->vector[i];

        if (v->count == 0) {
            continue;
        }
        (void)fprintf(out,
                      "%s{\"vector\":%d,\"name\":\"%s\",\"count\":%u,\"cycles_min\":%u,"
                      "\"cycles_sum\":%" PRIu64
                      ",\"cycles_mean\":%.2f,\"cycles_max\":%u,\"latency_max\":%u}",
                      comma,
                      i,
                      v->name,
                      v->count,
                      v->cycles_min,
                      v->cycles_sum,
                      (double)v->cycles_sum / v->count,
                      v->cycles_max,
                      v->latency_max);
        comma = ",";
    }
}

static void write_sections(FILE *out, struct board *b)
{
    struct irq_stats *s = &b->stats;

    irq_stats_section(s, b->avr->cycle); // up to now
    for (int i = 0; i < IRQ_SECTIONS; i++) {
        (void)fprintf(out, "%s%" PRIu64, (i == 0) ? "" : ",", s->section_cycles[i]);
    }
}

static void write_entries(FILE *out, const struct irq_stats *s)
{
    for (int i = 0; i < IRQ_SECTIONS; i++) {
        (void)fprintf(out, "%s%" PRIu64, (i == 0) ? "" : ",", s->section_entries[i]);
    }
}

static void write_longest(FILE *out, const struct irq_stats *s)
{
    for (int i = 0; i < IRQ_SECTIONS; i++) {
        (void)fprintf(out, "%s%" PRIu64, (i == 0) ? "" : ",", s->section_longest[i]);
    }
}

static void write_axes(FILE *out, const struct board *b)
{
    for (int i = 0; i < b->kind->axes; i++) {
        (void)fprintf(out,
                      "%s{\"steps_rising\":%" PRIu64 ",\"steps_signed\":%" PRId64 "}",
                      (i == 0) ? "" : ",",
                      b->outputs.axis[i].steps_rising,
                      b->outputs.axis[i].steps_signed);
    }
}

static void write_board(FILE *out, struct board *b)
{
    (void)fprintf(out, "{\"name\":\"%s\",\"handlers\":[", b->kind->name);
    write_handlers(out, &b->stats);
    (void)fprintf(out,
                  "],\"interrupt_cycles\":%" PRIu64 ",\"sections\":[",
                  b->stats.interrupt_cycles);
    write_sections(out, b);
    (void)fputs("],\"section_entries\":[", out);
    write_entries(out, &b->stats);
    (void)fputs("],\"section_longest\":[", out);
    write_longest(out, &b->stats);
    (void)fprintf(out,
                  "],\"sleep_cycles\":%" PRIu64 ",\"stack_free_bytes\":%u,"
                  "\"stack_used_bytes\":%u,\"axes\":[",
                  b->run_loop.sleep_cycles,
                  stack_free_bytes(&b->stack, b->avr),
                  stack_used_bytes(&b->stack, b->avr));
    write_axes(out, b);
    (void)fprintf(out,
                  "],\"interrupts_off_max_cycles\":%" PRIu64
                  ",\"interrupts_off_main_max_cycles\":%" PRIu64 "}",
                  b->stats.off_max,
                  b->stats.off_main_max);
}

void stats_write(FILE *out, struct bench *bench)
{
    double wall_s = bench_wall_s() - bench->wall_started_s;
    double simulated_s = (double)bench->cycle / cpu_clock_hz();

    (void)fprintf(out,
                  "{\"cycle\":%" PRIu64
                  ",\"wall_s\":%.3f,\"cpu_s\":%.3f,\"realtime_factor\":%.2f,"
                  "\"corrupted_frames\":%" PRIu64 ",\"boards\":[",
                  bench->cycle,
                  wall_s,
                  cpu_s(),
                  (wall_s > 0.0) ? simulated_s / wall_s : 0.0,
                  bench->bus.corrupted_frames);
    for (int i = 0; i < bench->boards; i++) {
        if (i > 0) {
            (void)fputc(',', out);
        }
        write_board(out, &bench->board[i]);
    }
    (void)fputs("]}", out);
}
