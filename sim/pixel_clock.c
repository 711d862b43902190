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

static int64_t jitter_cycles(struct pixel_clock *c)
{
    int64_t most = (int64_t)cpu_clock_cycles_of_us(c->settings.jitter_ns) / NS_PER_US;

    if (most == 0) {
        return 0;
    }
    return (int64_t)(noise_next(&c->random) % (uint64_t)(2 * most + 1)) - most;
}

static void set_period(struct pixel_clock *c)
{
    int64_t scaled = PPM_SCALE + llround(c->settings.ppm * PPM_UNITS);

    c->num = (pixel_wide)cpu_clock_hz() * c->settings.hz_den * (uint64_t)PPM_SCALE;
    c->den = (pixel_wide)c->settings.hz_num * (uint64_t)scaled;
}

void pixel_clock_set_ppm(struct pixel_clock *c, double ppm)
{
    c->settings.ppm = ppm;
    if (c->settings.hz_num != 0) {
        set_period(c);
        c->rest = 0;
    }
}

void pixel_clock_set_hz(struct pixel_clock *c,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        uint64_t cycle)
{
    c->settings.hz_num = hz_num;
    c->settings.hz_den = hz_den;
    set_period(c);
    c->rest = 0;
    c->ideal = cycle + (uint64_t)(c->num / c->den);
    c->next_valid = false;
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
    return csv_open(&c->log, log_path, "cycle");
}

static void advance_ideal(struct pixel_clock *c)
{
    pixel_wide sum = c->num + c->rest;

    c->ideal += (uint64_t)(sum / c->den);
    c->rest = sum % c->den;
}

static void make_next(struct pixel_clock *c)
{
    int64_t rise = (int64_t)c->ideal + jitter_cycles(c);
    int64_t soonest = (int64_t)(c->last_fall + GAP_CYCLES);
    uint64_t high = (uint64_t)(c->num / c->den) / 4;

    if (high >= cpu_clock_cycles_of_us(HIGH_MAX_US)) {
        high = cpu_clock_cycles_of_us(HIGH_MAX_US) - 1;
    }
    c->next.rise = (uint64_t)((rise > soonest) ? rise : soonest);
    c->next.fall = c->next.rise + high + 1;
    c->last_fall = c->next.fall;
    c->next_valid = true;
    advance_ideal(c);
}

// True if the pulse reaches the boards: the clock is on and the pulse is not dropped.
static bool is_emitted(struct pixel_clock *c)
{
    if (c->drop > 0) {
        c->drop--;
        return false;
    }
    return c->on;
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
        if (is_emitted(c)) {
            *pulse = c->next;
            if (c->log != NULL) {
                (void)fprintf(c->log, "%" PRIu64 "\n", pulse->rise);
            }
            return true;
        }
    }
}

void pixel_clock_close(struct pixel_clock *c)
{
    (void)csv_close(&c->log);
}
