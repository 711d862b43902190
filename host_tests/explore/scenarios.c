// SPDX-License-Identifier: MIT
// The situations from which the search begins.
#include "explore/board.h"
#include "explore/judge.h"
#include "explore/judged.h"
#include "explore/part.h"
#include "explore/scene.h"

// A line with a pulse train, single periods, intervals of several periods and a reversal. The first
// pixel of a line is never written as a whole, so that its steps are a train.
#define LINE(flags) BLOCK(START(flags), {17, 1}, {3, 1}, {1, 1}, {-1, 1}, END)
// Position behind both: all of 17 + 3 steps are made except the last.
#define BEHIND_TRAIN_STEPS 19

static bool running(void)
{
    return scene_axis()->life.state == AXIS_RUNNING;
}

static bool in_delay(void)
{
    return running() && scene_engine()->state == STEP_ENGINE_IN_LINE;
}

static bool before_pulse(void)
{
    uint8_t tail = scene_engine()->tail;

    return in_delay() && step_rings[0].high[tail] == STEP_HIGH_COMMAND &&
           step_rings[0].low[tail] == STEP_COMMAND_PULSE;
}

static bool in_singles(void)
{
    return in_delay() && scene_engine()->pulse && scene_engine()->left == 0;
}

static bool in_train(void)
{
    return in_delay() && scene_engine()->left > 1;
}

static bool near_end_of_train(void)
{
    return in_delay() && scene_engine()->left == 1;
}

// Behind the pulse train: the step is made, and the interval behind it goes on.
static bool in_long_interval(void)
{
    return in_delay() && judged.position >= BEHIND_TRAIN_STEPS && !scene_engine()->pulse;
}

static bool reverses(void)
{
    return in_delay() && scene_engine()->negative;
}

static bool line_ended(void)
{
    return running() && scene_engine()->state == STEP_ENGINE_IDLE &&
           scene_axis()->phase == DECODE_OUTSIDE &&
           scene_axis()->feed.stream.head == scene_engine()->tail;
}

static bool before_end(void)
{
    return in_delay() && scene_axis()->phase == DECODE_OUTSIDE &&
           (uint8_t)(scene_axis()->feed.stream.head - scene_engine()->tail) == 1;
}

static bool starving(void)
{
    return in_delay() && scene_axis()->phase == DECODE_DRY &&
           scene_axis()->feed.stream.head == scene_engine()->tail;
}

static bool failed(void)
{
    return scene_axis()->life.state == AXIS_FAULT;
}

static bool finished(void)
{
    return scene_axis()->life.state == AXIS_DONE;
}

static bool load_and_arm(void)
{
    return LINE(0) && scene_arm(0);
}

static bool prepare_empty(void)
{
    return true;
}

static bool prepare_loaded(void)
{
    return LINE(0);
}

static bool prepare_held(void)
{
    return LINE(LINE_START_WAIT) && scene_arm(0);
}

static bool prepare_held_by_token(void)
{
    return LINE(0) && scene_arm(SCENE_TOKEN);
}

static bool prepare_armed(void)
{
    return load_and_arm();
}

static bool prepare_delay(void)
{
    return load_and_arm() && scene_pass_until(running);
}

static bool prepare_before_pulse(void)
{
    return load_and_arm() && scene_pass_until(before_pulse);
}

static bool prepare_singles(void)
{
    return load_and_arm() && scene_pass_until(in_singles);
}

static bool prepare_train(void)
{
    return load_and_arm() && scene_pass_until(in_train);
}

static bool prepare_end_of_train(void)
{
    return load_and_arm() && scene_pass_until(near_end_of_train);
}

static bool prepare_long_interval(void)
{
    return load_and_arm() && scene_pass_until(in_long_interval);
}

static bool prepare_reversal(void)
{
    return load_and_arm() && scene_pass_until(reverses);
}

static bool prepare_before_end(void)
{
    return load_and_arm() && scene_pass_until(before_end);
}

static bool prepare_ended(void)
{
    return load_and_arm() && scene_pass_until(line_ended);
}

static bool prepare_done(void)
{
    return load_and_arm() && scene_pass_until(finished);
}

// A line that the host streams, until the host falls silent.
static bool load_open_line(void)
{
    bool taken = BLOCK(START(0), {1, 1}, {2, 1});

    for (uint8_t i = 0; i < 12; i++) {
        taken = taken && BLOCK({1, 1}, {2, 1});
    }
    return taken && scene_arm(0);
}

static bool prepare_starving(void)
{
    return load_open_line() && scene_pass_until(starving);
}

static bool prepare_starved(void)
{
    return load_open_line() && scene_pass_until(failed);
}

static bool prepare_stopping(void)
{
    bool stopped = prepare_train() && scene_order(COMMAND_STOP, 0);

    judge_between();
    return stopped;
}

static bool prepare_estop(void)
{
    bool there = prepare_singles();

    part_happen(PART_PIN_CHANGES);
    return there && scene_pass_until(failed);
}

// Intervals that are short enough for an underrun.
static bool load_fast(void)
{
    scene_pixel_hz(850);
    return BLOCK(START(0), {12, 1}, {130, 1}, {12, 1}, END) && scene_arm(0);
}

static bool prepare_fast_singles(void)
{
    return load_fast() && scene_pass_until(in_singles);
}

static bool prepare_fast_train(void)
{
    return load_fast() && scene_pass_until(in_train);
}

struct scenario {
    const char *name;
    bool (*prepare)(void);
};

static const struct scenario scenarios[] = {
    {"empty", prepare_empty},
    {"loaded", prepare_loaded},
    {"armed, about to be released", prepare_armed},
    {"armed, waits for the pixel clock", prepare_held},
    {"armed, waits for its token", prepare_held_by_token},
    {"released, before its delay", prepare_delay},
    {"before the first step", prepare_before_pulse},
    {"single periods", prepare_singles},
    {"inside a run", prepare_train},
    {"last period of a run", prepare_end_of_train},
    {"inside a long interval", prepare_long_interval},
    {"behind a reversal", prepare_reversal},
    {"before the end command", prepare_before_end},
    {"behind the end command", prepare_ended},
    {"done", prepare_done},
    {"about to starve", prepare_starving},
    {"starved", prepare_starved},
    {"stopping", prepare_stopping},
    {"emergency stop", prepare_estop},
    {"short single periods", prepare_fast_singles},
    {"inside a fast run", prepare_fast_train},
};

uint16_t board_scenarios(void)
{
    return sizeof scenarios / sizeof scenarios[0];
}

const char *board_scenario(uint16_t scenario)
{
    return scenarios[scenario].name;
}

bool board_prepare(uint16_t scenario)
{
    return scenarios[scenario].prepare();
}
