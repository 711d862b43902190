// SPDX-License-Identifier: MIT

#include "pixel_clock.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "cpu_clock.h"
#include "csv_file.h"

#define HIGH_MAX_US 50U
#define GAP_CYCLES  2U // low at least between two pulses, whatever the jitter
#define PPM_SCALE   1000000000000LL // the nominal frequency, in millionths of a ppm
#define PPM_UNITS   1e6
#define NS_PER_US   1000
#define TWO_PI      6.283185307179586

// The sum of so many numbers, evenly distributed between 0 and 1, has a variance of 1 and is nearly
// normally distributed, by whole numbers alone: the same on every machine.
#define NORMAL_SUM 12

// A false edge lies behind a true one by a part of the period between these, in thousandths.
#define FALSE_FIRST 50U
#define FALSE_LAST  700U
#define THOUSAND    1000U

const char *pixel_edge_name(enum pixel_edge kind)
{
    static const char *const names[] = {"true", "missing", "false"};

    return names[kind];
}

static int64_t even_cycles(struct pixel_clock *c)
{
    int64_t most = (int64_t)cpu_clock_cycles_of_us(c->settings.jitter_ns) / NS_PER_US;

    if (most == 0) {
        return 0;
    }
    return (int64_t)(noise_next(&c->random) % (uint64_t)(2 * most + 1)) - most;
}

static int64_t normal_cycles(struct pixel_clock *c)
{
    int64_t rms_x1000 = (int64_t)cpu_clock_cycles_of_us(c->settings.jitter_rms_ns);
    int64_t sum = -(int64_t)NORMAL_SUM * INT32_MAX / 2;

    if (rms_x1000 == 0) {
        return 0;
    }
    for (int i = 0; i < NORMAL_SUM; i++) {
        sum += (int64_t)(noise_next(&c->random) >> 33);
    }
    return sum / NS_PER_US * rms_x1000 / INT32_MAX;
}

// The frequency error of the period that follows edge c->edge.
static double ppm_now(const struct pixel_clock *c)
{
    const struct pixel_clock_settings *s = &c->settings;
    double ppm = s->ppm;

    if (s->wander_ppm > 0) {
        ppm += s->wander_ppm * sin(TWO_PI * (double)c->edge / PIXEL_CLOCK_WANDER_EDGES);
    }
    if (s->step_edge != 0 && c->edge >= s->step_edge) {
        ppm += s->step_ppm;
    }
    return ppm;
}

// Keeps the fraction of a cycle that the next edge has.
static void set_period(struct pixel_clock *c)
{
    int64_t scaled = PPM_SCALE + llround(ppm_now(c) * PPM_UNITS);
    pixel_wide old = c->den;

    c->num = (pixel_wide)cpu_clock_hz() * c->settings.hz_den * (uint64_t)PPM_SCALE;
    c->den = (pixel_wide)c->settings.hz_num * (uint64_t)scaled;
    if (old != c->den && c->rest != 0) {
        c->rest =
            (pixel_wide)((long double)c->rest / (long double)old * (long double)c->den);
    }
}

static bool is_steady(const struct pixel_clock *c)
{
    return !(c->settings.wander_ppm > 0) && c->settings.step_edge != c->edge;
}

void pixel_clock_set_ppm(struct pixel_clock *c, double ppm)
{
    c->settings.ppm = ppm;
    if (c->settings.hz_num != 0) {
        c->rest = 0;
        set_period(c);
    }
}

void pixel_clock_set_jitter(struct pixel_clock *c,
                            uint32_t jitter_ns,
                            uint32_t jitter_rms_ns)
{
    c->settings.jitter_ns = jitter_ns;
    c->settings.jitter_rms_ns = jitter_rms_ns;
}

void pixel_clock_set_hz(struct pixel_clock *c,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        uint64_t cycle)
{
    c->settings.hz_num = hz_num;
    c->settings.hz_den = hz_den;
    c->rest = 0;
    set_period(c);
    c->ideal = cycle + (uint64_t)(c->num / c->den);
    c->next_valid = false;
    c->last_fall = c->given_fall;
    c->false_due = false;
    c->burst = 0;
}

uint64_t pixel_clock_period(const struct pixel_clock *c)
{
    return (c->settings.hz_num != 0) ? (uint64_t)(c->num / c->den) : 0;
}

uint64_t pixel_clock_quiet(const struct pixel_clock *c)
{
    return c->next_valid ? c->next.rise : UINT64_MAX;
}

bool pixel_clock_open(struct pixel_clock *c,
                      const struct pixel_clock_settings *settings,
                      const char *log_path)
{
    memset(c, 0, sizeof *c);
    c->settings = *settings;
    c->on = true;
    c->random.state = settings->seed * 0x9E3779B97F4A7C15U + 1;
    c->ideal = (uint64_t)llround(settings->start_ms * (double)cpu_clock_cycles_of_ms(1));
    if (settings->hz_num != 0) {
        set_period(c);
    }
    return csv_open(&c->log, log_path, "cycle,true_cycle_x1000,edge");
}

static uint64_t ideal_x1000(const struct pixel_clock *c)
{
    return c->ideal * THOUSAND +
           (uint64_t)((long double)c->rest / (long double)c->den * THOUSAND);
}

static void advance_ideal(struct pixel_clock *c)
{
    pixel_wide sum;

    if (!is_steady(c)) {
        set_period(c);
    }
    sum = c->num + c->rest;
    c->ideal += (uint64_t)(sum / c->den);
    c->rest = sum % c->den;
    c->edge++;
}

// The next pulse may be made already.
void pixel_clock_set_gate(struct pixel_clock *c, uint32_t edges, double rest_ms)
{
    c->settings.gate_edges = edges;
    c->settings.gate_rest_ms = rest_ms;
    c->burst = c->next_valid ? 1 : 0;
}

// Puts the rest before the next edge if the gate has let all of its edges pass.
static void pass_gate(struct pixel_clock *c)
{
    if (c->settings.gate_edges != 0 && c->burst >= c->settings.gate_edges) {
        c->burst = 0;
        c->ideal += (uint64_t)llround(c->settings.gate_rest_ms *
                                      (double)cpu_clock_cycles_of_ms(1));
    }
    c->burst++;
}

void pixel_clock_rest(struct pixel_clock *c, uint64_t cycles)
{
    c->ideal += cycles;
    if (c->next_valid) {
        c->next.rise += cycles;
        c->next.fall += cycles;
        c->next.true_x1000 += cycles * THOUSAND;
        c->last_fall = c->next.fall;
    }
}

// One edge of so many is missing, the last one of them; the one doubled is that in the middle.
static bool is_dropped(const struct pixel_clock *c)
{
    uint32_t every = c->settings.drop_every;

    return every != 0 && c->edge % every == every - 1;
}

static bool is_doubled(const struct pixel_clock *c)
{
    uint32_t every = c->settings.double_every;

    return every != 0 && c->edge % every == every / 2;
}

static void place_next(struct pixel_clock *c, int64_t rise)
{
    int64_t soonest = (int64_t)(c->last_fall + GAP_CYCLES);
    uint64_t high = (uint64_t)(c->num / c->den) / 4;

    if (high >= cpu_clock_cycles_of_us(HIGH_MAX_US)) {
        high = cpu_clock_cycles_of_us(HIGH_MAX_US) - 1;
    }
    c->next.rise = (uint64_t)((rise > soonest) ? rise : soonest);
    c->next.fall = c->next.rise + high + 1;
    c->last_fall = c->next.fall;
    c->next_valid = true;
}

uint32_t pixel_clock_false_phase(struct noise *random)
{
    return FALSE_FIRST + (uint32_t)(noise_next(random) % (FALSE_LAST - FALSE_FIRST + 1));
}

static void make_false(struct pixel_clock *c)
{
    uint64_t part = pixel_clock_false_phase(&c->random);
    uint64_t after = (uint64_t)(c->num / c->den) * part / THOUSAND;

    c->next.kind = PIXEL_EDGE_FALSE;
    place_next(c, (int64_t)(c->next.true_x1000 / THOUSAND + after));
    c->false_due = false;
}

static void make_true(struct pixel_clock *c)
{
    pass_gate(c);
    c->next.kind = is_dropped(c) ? PIXEL_EDGE_MISSING : PIXEL_EDGE_TRUE;
    c->next.true_x1000 = ideal_x1000(c);
    c->false_due = c->next.kind == PIXEL_EDGE_TRUE && is_doubled(c);
    place_next(c, (int64_t)c->ideal + even_cycles(c) + normal_cycles(c));
    advance_ideal(c);
}

static void make_next(struct pixel_clock *c)
{
    if (c->false_due) {
        make_false(c);
    } else {
        make_true(c);
    }
}

// Counts the pulses that a command drops.
static void drop_if_asked(struct pixel_clock *c)
{
    if (c->drop > 0) {
        c->drop--;
        c->next.kind = PIXEL_EDGE_MISSING;
    }
}

static void log_next(const struct pixel_clock *c)
{
    if (c->log != NULL) {
        (void)fprintf(c->log,
                      "%" PRIu64 ",%" PRIu64 ",%s\n",
                      c->next.rise,
                      c->next.true_x1000,
                      pixel_edge_name(c->next.kind));
    }
}

bool pixel_clock_next(struct pixel_clock *c, uint64_t before, struct pixel_pulse *pulse)
{
    if (c->settings.hz_num == 0) {
        return false;
    }
    for (;;) {
        if (!c->next_valid) {
            make_next(c);
        }
        if (c->next.rise >= before) {
            return false;
        }
        c->next_valid = false;
        drop_if_asked(c);
        if (!c->on) {
            continue;
        }
        log_next(c);
        if (c->next.kind != PIXEL_EDGE_MISSING) {
            *pulse = c->next;
            c->given_fall = pulse->fall;
            return true;
        }
    }
}

bool pixel_clock_close(struct pixel_clock *c)
{
    return csv_close(&c->log);
}
