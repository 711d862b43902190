// SPDX-License-Identifier: MIT
// The situations from which the search begins: every moment of a few runs of two axes, one before
// each timed event.
#include <stdio.h>

#include "app/axes/reference.h"
#include "app/settings/settings.h"
#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"
#include "explore/program.h"
#include "explore/two/board.h"
#include "explore/two/scene.h"

#define NAME_BYTES 64u

static bool load(uint16_t flags_0, uint16_t flags_1)
{
    return scene_line(0, LINE_OF_22, flags_0) && scene_line(1, LINE_OF_24, flags_1);
}

static bool begin_free(void)
{
    return load(0, 0) && scene_arm(BOTH, 0);
}

static bool begin_one(void)
{
    return load(0, 0) && scene_arm(axis_bit(0), 0);
}

static bool begin_other(void)
{
    return load(0, 0) && scene_arm(axis_bit(1), 0);
}

static bool begin_clocked(void)
{
    scene_sync(SYNC_START);
    return load(LINE_START_WAIT, LINE_START_WAIT) && scene_arm(BOTH, 0);
}

static bool known(void)
{
    return reference_present();
}

static bool begin_held(void)
{
    scene_sync(SYNC_START);
    return scene_pass_until(known) && load(LINE_START_WAIT, LINE_START_WAIT) &&
           scene_arm(BOTH, SCENE_TOKEN);
}

static bool begin_by_token(void)
{
    return begin_held() && scene_go(SCENE_TOKEN);
}

static bool lock(uint16_t flags_0, uint16_t flags_1)
{
    scene_sync(SYNC_LOCK);
    return scene_pass_until(reference_settled) && load(flags_0, flags_1) &&
           scene_arm(BOTH, 0);
}

static bool begin_locked(void)
{
    return lock(LINE_START_WAIT, LINE_START_WAIT);
}

static bool begin_locked_beside(void)
{
    return lock(LINE_START_WAIT, 0);
}

static bool begin_beside_locked(void)
{
    return lock(0, LINE_START_WAIT);
}

// An edge of the clock comes inside the train of axis 1, whose timer captures it.
static bool begin_late(void)
{
    scene_sync(SYNC_LOCK);
    if (!scene_pass_until(reference_settled) ||
        !scene_line(0, LINE_OF_22, LINE_START_WAIT) || !scene_line(1, LINE_OF_50, 0)) {
        return false;
    }
    part_pass_long_time(PIXEL_TICKS / 2u);
    board_round();
    return scene_arm(BOTH, 0);
}

static bool begin_idle(void)
{
    return load(0, 0);
}

struct run {
    const char *name;
    bool (*begin)(void);
    uint16_t moments; // up to the end of both lines
};

static const struct run runs[] = {
    {"loaded", begin_idle, 2},
    {"both run", begin_free, 64},
    {"axis 0 runs", begin_one, 58},
    {"axis 1 runs", begin_other, 50},
    {"both begin on an edge", begin_clocked, 72},
    {"both wait for their token", begin_held, 2},
    {"both begin by a token", begin_by_token, 62},
    {"both locked", begin_locked, 68},
    {"axis 0 locked", begin_locked_beside, 72},
    {"axis 1 locked", begin_beside_locked, 69},
    {"axis 0 locked, armed late", begin_late, 90},
};

#define RUNS (sizeof runs / sizeof runs[0])

// The run of a scenario; *moment: of that run.
static const struct run *run_of(uint16_t scenario, uint16_t *moment)
{
    const struct run *run = runs;

    while (scenario >= run->moments) {
        scenario = (uint16_t)(scenario - run->moments);
        run++;
    }
    *moment = scenario;
    return run;
}

uint16_t board_scenarios(void)
{
    uint16_t moments = 0;

    for (size_t i = 0; i < RUNS; i++) {
        moments = (uint16_t)(moments + runs[i].moments);
    }
    return moments;
}

const char *board_scenario(uint16_t scenario)
{
    // Not a part of any state.
    static char *name;
    uint16_t moment = 0;
    const struct run *run = run_of(scenario, &moment);

    if (name == NULL) {
        name = allocate(NULL, NAME_BYTES);
    }
    (void)snprintf(name, NAME_BYTES, "%s, moment %u", run->name, moment);
    return name;
}

bool board_prepare(uint16_t scenario)
{
    uint16_t moment = 0;

    if (!run_of(scenario, &moment)->begin()) {
        return false;
    }
    for (; moment != 0; moment--) {
        board_idle();
    }
    part_pass_long_time(PART_BEFORE_TICKS);
    board_round();
    judge_between();
    return true;
}
