// SPDX-License-Identifier: MIT
#include "app/watch/time_check.h"

#include "app/axes/axes.h"   // axes_*
#include "app/axes/faults.h" // faults_latch_underrun
#include "app/axes/mark.h"   // mark_started
#include "base/apart.h"      // APART
#include "hal/clock.h"       // clock_now_units
#include "hal/step_timer.h"  // step_timer_start
#include "ring/step_codes.h" // STEP_IDLE_TICKS

// Time between two checks. A check inside a pulse train divides and costs up to 1500 cycles.
#define CHECK_EVERY_UNITS 1024u

// An account may be ahead of the coarse clock by the rounding of that clock, CLOCK_UNIT_TICKS, and
// behind it by this much, ticks: what is left of the rounding when the clock was set, and the
// cycles between the two looks.
#define SLACK_TICKS        24
#define CLOCK_BEHIND_TICKS ((int32_t)(CLOCK_UNIT_TICKS + SLACK_TICKS))
// Looks that find when the timers started.
#define START_LOOKS 40u
// Looks at a fast axis, until one of them would show a missing period, or so many units have
// passed (2 ms at 16 MHz): its steps may leave a quarter of the processor, and its next train is
// to be made.
#define LAG_LOOKS      8u
#define LAG_MOST_UNITS 512u

// The coarse clock when the timers started, ticks.
static uint32_t started_ticks;
static uint16_t
    checked_units; // last check, a multiple of CHECK_EVERY_UNITS that tells whose turn it is

// A little time, more for a larger number.
static void pause(uint8_t turns)
{
    for (volatile uint8_t left = turns; left != 0; left--) {
    }
}

// The clock's count is rounded down: of all looks the one says most that came just behind a count.
// Each distance of two looks differs from the one before: were they all a whole number of counts,
// every look would come equally long behind one.
static void find_start(void)
{
    struct step_timer_look look;
    bool found = false;

    for (uint8_t looks = START_LOOKS; looks != 0; looks--) {
        pause(looks);
        if (!step_timer_look(0, &look)) {
            continue;
        }
        uint32_t start = look.units * CLOCK_UNIT_TICKS - look.counter;
        // Of idle periods, all of the same length, any may be running.
        uint32_t later = (start - started_ticks) % STEP_IDLE_TICKS;

        if (!found) {
            started_ticks = start;
        } else if (later < CLOCK_UNIT_TICKS) {
            started_ticks += later;
        }
        found = true;
    }
}

void time_check_start(void)
{
    step_timer_start();
    mark_started();
    // A board with a single axis makes no checks.
    if (CONFIG_AXES > 1) {
        find_start();
    }
}

uint32_t time_check_now_ticks(void)
{
    return clock_now_units() * CLOCK_UNIT_TICKS - started_ticks;
}

// Without a look: nobody may serve the axis. Then its newest loaded period has begun, by the clock,
// and is still the newest.
static bool is_left_behind(uint8_t i)
{
    struct axis *axis = axes_get(i);
    // Before the account is brought up to date: the time is never ahead of it.
    uint32_t now_ticks = time_check_now_ticks();

    if (!axes_advance(i, LEDGER_EXACTLY)) {
        return false;
    }
    uint32_t newest_start = ledger_period_start(&axis->ledger, &axis->feed.stream, 0);
    return (int32_t)(now_ticks - newest_start) > SLACK_TICKS;
}

// The axis makes, or has made, periods that are near the coarse clock's unit.
static bool is_fast(uint8_t i)
{
    const struct pulse_train *trains = step_timer_trains(i);
    bool fast = false;

    for (uint8_t k = 0; k < STEP_TRAINS; k++) {
        uint8_t low = trains[k].short_low; // of a train that was never used, 0
        fast = fast || (trains[k].top_high == 0 && low != 0 &&
                        low < CLOCK_UNIT_TICKS + SLACK_TICKS);
    }
    return fast;
}

// A missing period as short as the clock's unit shows, unless the rounding of the clock and the
// slack hide it: late in a unit.
static bool hides_unit(uint32_t account_ticks)
{
    uint8_t into_unit = (uint8_t)(account_ticks + started_ticks) % CLOCK_UNIT_TICKS;

    return into_unit >= CLOCK_UNIT_TICKS - SLACK_TICKS;
}

//     account    |- running ---|- newest loaded -|
//                |--counter-->^ now                     by the account
//     clock      |---------------->^                    an interrupt was missed: now is later
bool time_check_lags(uint8_t i)
{
    if (CONFIG_AXES == 1) {
        return false;
    }
    struct step_timer_look look;
    uint32_t account_ticks = 0;
    uint8_t looks = is_fast(i) ? LAG_LOOKS : 1u;
    uint32_t began_units = clock_now_units();

    do {
        if (!step_timer_look(i, &look)) {
            return is_left_behind(i);
        }
        if (!axes_time_at(i, &look.sample, look.counter, &account_ticks)) {
            return false;
        }
        uint32_t now_ticks = look.units * CLOCK_UNIT_TICKS - started_ticks;
        // The coarse clock itself has lost time when it is further behind than it is rounded.
        int32_t later_ticks = (int32_t)(now_ticks - account_ticks);
        if (later_ticks > SLACK_TICKS || later_ticks < -CLOCK_BEHIND_TICKS) {
            return true;
        }
        looks--;
    } while (looks != 0 && look.units - began_units < LAG_MOST_UNITS &&
             hides_unit(account_ticks));
    return false;
}

bool time_check_passes(uint8_t i)
{
    // A time base that is lost is named already, and begins anew before anything moves again.
    if (CONFIG_AXES == 1 || faults_time_lost() || !time_check_lags(i)) {
        return true;
    }
    faults_latch_underrun(i);
    return false;
}

// A halt that is not over counts its periods in two ways; a parked axis counts none.
static bool can_be_checked(uint8_t i)
{
    enum step_engine_state state = step_timer_state(i);

    return state != STEP_ENGINE_HALTING && state != STEP_ENGINE_PARKED;
}

// Apart from the round, which has more to keep in registers than there are.
static APART void check_next(void)
{
    checked_units = (uint16_t)(checked_units + CHECK_EVERY_UNITS);
    uint8_t i = (uint8_t)(checked_units / CHECK_EVERY_UNITS) % CONFIG_AXES;

    if (can_be_checked(i)) {
        (void)time_check_passes(i);
    }
}

void time_check_poll(void)
{
    if ((uint16_t)((uint16_t)clock_now_units() - checked_units) >= CHECK_EVERY_UNITS) {
        check_next();
    }
}
