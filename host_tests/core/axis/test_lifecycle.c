// SPDX-License-Identifier: MIT
// Every state of an axis with every event, forbidden ones included.
#include "axis/lifecycle.h"
#include "base/flash.h"
#include "unity.h"

static struct lifecycle life;

void setUp(void)
{
    lifecycle_reset(&life);
}

void tearDown(void)
{
}

#define PATH_EVENTS 6u
#define END         ((char)LIFECYCLE_EVENTS)

// The events that lead from EMPTY to each state.
static const char paths[AXIS_STATES][PATH_EVENTS] IN_FLASH = {
    [AXIS_EMPTY] = {END},
    [AXIS_LOADING] = {LIFECYCLE_QUEUED, END},
    [AXIS_LOADED] = {LIFECYCLE_READY, END},
    [AXIS_ARMED] = {LIFECYCLE_READY, LIFECYCLE_ARM, END},
    [AXIS_RUNNING] =
        {LIFECYCLE_READY, LIFECYCLE_ARM, LIFECYCLE_PLACED, LIFECYCLE_RELEASED, END},
    [AXIS_DONE] = {LIFECYCLE_READY,
                   LIFECYCLE_ARM,
                   LIFECYCLE_PLACED,
                   LIFECYCLE_RELEASED,
                   LIFECYCLE_FINISHED,
                   END},
    [AXIS_REFUSED] = {LIFECYCLE_REFUSE, END},
    [AXIS_FAULT] = {LIFECYCLE_READY, LIFECYCLE_ARM, LIFECYCLE_FAIL, END},
    [AXIS_STARTING] = {LIFECYCLE_READY, LIFECYCLE_ARM, LIFECYCLE_PLACED, END},
    [AXIS_STOPPING] = {LIFECYCLE_STOP, END},
};

static void reach(enum axis_state state)
{
    lifecycle_reset(&life);
    for (uint8_t i = 0; i < PATH_EVENTS; i++) {
        char event = flash_char(&paths[state][i]);
        if (event == END) {
            break;
        }
        TEST_ASSERT_TRUE(lifecycle_report(&life, (enum lifecycle_event)event));
    }
    TEST_ASSERT_EQUAL_UINT8(state, life.state);
}

static void every_state_can_be_reached(void)
{
    for (uint8_t state = 0; state < (uint8_t)AXIS_STATES; state++) {
        reach((enum axis_state)state);
    }
}

#define BIT(state) (1u << (state))
#define QUEUEABLE                                                                        \
    (BIT(AXIS_EMPTY) | BIT(AXIS_LOADING) | BIT(AXIS_LOADED) | BIT(AXIS_DONE))
#define MOVING (BIT(AXIS_ARMED) | BIT(AXIS_STARTING) | BIT(AXIS_RUNNING))
#define EVERY  ((1u << AXIS_STATES) - 1u)

// The effect of an event: in some states it leads to another state, in some it changes nothing, and
// in all others it is forbidden.
static void check(enum lifecycle_event event, uint16_t from, uint8_t to, uint16_t stays)
{
    for (uint8_t state = 0; state < (uint8_t)AXIS_STATES; state++) {
        bool changes = (from & BIT(state)) != 0;
        bool taken = changes || (stays & BIT(state)) != 0;

        reach((enum axis_state)state);
        TEST_ASSERT_EQUAL(taken, lifecycle_report(&life, event));
        TEST_ASSERT_EQUAL_UINT8(changes ? to : state, life.state);
    }
}

static void a_block_that_leaves_the_line_open(void)
{
    check(LIFECYCLE_QUEUED,
          QUEUEABLE & ~BIT(AXIS_LOADED),
          AXIS_LOADING,
          MOVING | BIT(AXIS_LOADED));
}

static void a_block_after_which_a_line_can_be_armed(void)
{
    check(LIFECYCLE_READY, QUEUEABLE, AXIS_LOADED, MOVING);
}

static void a_refused_block(void)
{
    check(LIFECYCLE_REFUSE, QUEUEABLE, AXIS_REFUSED, MOVING);
}

static void from_loaded_to_done(void)
{
    check(LIFECYCLE_ARM, BIT(AXIS_LOADED), AXIS_ARMED, 0);
    check(LIFECYCLE_PLACED, BIT(AXIS_ARMED), AXIS_STARTING, 0);
    check(LIFECYCLE_RELEASED, BIT(AXIS_STARTING), AXIS_RUNNING, 0);
    check(LIFECYCLE_FINISHED, BIT(AXIS_RUNNING), AXIS_DONE, 0);
}

static void a_fault_ends_what_moves(void)
{
    check(LIFECYCLE_FAIL, MOVING, AXIS_FAULT, EVERY & ~MOVING);
}

static void a_stop_ends_every_state(void)
{
    check(LIFECYCLE_STOP, EVERY, AXIS_STOPPING, 0);
    check(LIFECYCLE_SETTLED, BIT(AXIS_STOPPING), AXIS_EMPTY, 0);
}

// The register shows only eight states: two more states are shown as one of these.
static void what_the_register_shows(void)
{
    for (uint8_t state = 0; state < (uint8_t)AXIS_STARTING; state++) {
        reach((enum axis_state)state);
        TEST_ASSERT_EQUAL_UINT8(state, lifecycle_shown(&life));
    }
    reach(AXIS_STARTING);
    TEST_ASSERT_EQUAL_UINT8(AXIS_ARMED, lifecycle_shown(&life));
    reach(AXIS_STOPPING);
    TEST_ASSERT_EQUAL_UINT8(AXIS_EMPTY, lifecycle_shown(&life));
}

static void what_is_armed_and_what_moves(void)
{
    for (uint8_t state = 0; state < (uint8_t)AXIS_STATES; state++) {
        reach((enum axis_state)state);
        TEST_ASSERT_EQUAL(((MOVING & ~BIT(AXIS_RUNNING)) & BIT(state)) != 0,
                          lifecycle_armed(&life));
        TEST_ASSERT_EQUAL((MOVING & BIT(state)) != 0, lifecycle_moving(&life));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_state_can_be_reached);
    RUN_TEST(a_block_that_leaves_the_line_open);
    RUN_TEST(a_block_after_which_a_line_can_be_armed);
    RUN_TEST(a_refused_block);
    RUN_TEST(from_loaded_to_done);
    RUN_TEST(a_fault_ends_what_moves);
    RUN_TEST(a_stop_ends_every_state);
    RUN_TEST(what_the_register_shows);
    RUN_TEST(what_is_armed_and_what_moves);
    return UNITY_END();
}
