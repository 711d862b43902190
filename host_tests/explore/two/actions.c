// SPDX-License-Identifier: MIT
// The actions of the host, and those of a hand at the emergency stop.
#include <string.h>

#include "app/axes/limits.h"
#include "app/axes/permit.h"
#include "app/axes/reference.h"
#include "app/axes/token.h"
#include "app/motion/seek.h"
#include "app/settings/settings.h"
#include "app/watch/drivers.h"
#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"
#include "explore/program.h"
#include "explore/two/judged.h"
#include "explore/two/scene.h"

// Room for everything that a refused order must leave as it was, compared byte by byte.
#define OBSERVED_BYTES 16384u

// Room for two observations. The memory is allocated before the first state is saved, so that
// observations are not part of a state.
static uint8_t *observed;

void board_open(void)
{
    observed = allocate(NULL, 2u * OBSERVED_BYTES);
}

static uint8_t *note(uint8_t *seen, const void *object, size_t bytes)
{
    memcpy(seen, object, bytes);
    return &seen[bytes];
}

static uint8_t *note_modules(uint8_t *seen)
{
    uint16_t token = token_now();
    uint8_t drivers = drivers_on();
    uint8_t permit = permit_is_on();

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        seen = note(seen, axes_get(i), sizeof(struct axis));
    }
    seen = note(seen, faults_record(), sizeof(struct fault_record));
    seen = note(seen, settings_now(), sizeof(struct settings));
    seen = note(seen, reference_watch(), sizeof(struct clock_watch));
    seen = note(seen, reference_period(), sizeof(struct pixel_period));
    seen = note(seen, limits_together(CONFIG_AXES), sizeof(struct line_limits));
    seen = note(seen, seek_now(), sizeof(struct seek));
    seen = note(seen, commands_last(), sizeof(struct order));
    seen = note(seen, &token, sizeof token);
    seen = note(seen, &drivers, sizeof drivers);
    return note(seen, &permit, sizeof permit);
}

// Note everything that a refused order must leave alone. Returns the number of bytes.
static size_t observe(uint8_t *to)
{
    uint8_t permit = part_permit_high();
    uint8_t *seen = note_modules(to);

    seen = note(seen, step_engines, sizeof step_engines);
    seen = note(seen, step_rings, sizeof step_rings);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct part_timer *timer = &part.timers[i];
        seen = note(seen, &timer->buffer_top, sizeof timer->buffer_top);
        seen = note(seen, &timer->buffer_edge, sizeof timer->buffer_edge);
    }
    seen = note(seen, &permit, sizeof permit);
    return (size_t)(seen - to);
}

enum kind {
    KIND_ORDER,
    KIND_ARM,
    KIND_GO,
    KIND_LINE,
    KIND_REFUSED_BLOCK,
    KIND_PRESS,
    KIND_RELEASE,
    KIND_NOTHING
};

struct action {
    const char *name;
    uint8_t kind;
    uint8_t command;
    uint8_t mask; // of axes; the axis of a block
    uint8_t argument;
};

static const struct action actions[] = {
    {"nothing", KIND_NOTHING, 0, 0, 0},
    {"arm axis 0", KIND_ARM, COMMAND_ARM, 1, 0},
    {"arm axis 1", KIND_ARM, COMMAND_ARM, 2, 0},
    {"arm both", KIND_ARM, COMMAND_ARM, 3, 0},
    {"arm both with a token", KIND_ARM, COMMAND_ARM, 3, SCENE_TOKEN},
    {"arm axis 1 with a token", KIND_ARM, COMMAND_ARM, 2, SCENE_TOKEN},
    {"go", KIND_GO, COMMAND_GO, 0, SCENE_TOKEN},
    {"go with another token", KIND_GO, COMMAND_GO, 0, SCENE_OTHER_TOKEN},
    {"stop axis 0", KIND_ORDER, COMMAND_STOP, 1, 0},
    {"stop axis 1", KIND_ORDER, COMMAND_STOP, 2, 0},
    {"stop both", KIND_ORDER, COMMAND_STOP, 3, 0},
    {"disarm axis 0", KIND_ORDER, COMMAND_DISARM, 1, 0},
    {"disarm axis 1", KIND_ORDER, COMMAND_DISARM, 2, 0},
    {"discard axis 0", KIND_ORDER, COMMAND_DISCARD, 1, 0},
    {"discard axis 1", KIND_ORDER, COMMAND_DISCARD, 2, 0},
    {"clear fault", KIND_ORDER, COMMAND_CLEAR_FAULT, 1, 0},
    {"disable axis 0", KIND_ORDER, COMMAND_DISABLE, 1, 0},
    {"disable axis 1", KIND_ORDER, COMMAND_DISABLE, 2, 0},
    {"permit on", KIND_ORDER, COMMAND_PERMIT_ON, 1, 0},
    {"permit off", KIND_ORDER, COMMAND_PERMIT_OFF, 1, 0},
    {"a block for axis 0", KIND_LINE, 0, 0, 0},
    {"a block for axis 1", KIND_LINE, 0, 1, 0},
    {"a block that axis 1 refuses", KIND_REFUSED_BLOCK, 0, 1, 0},
    {"press the emergency stop", KIND_PRESS, 0, 0, 0},
    {"release the emergency stop", KIND_RELEASE, 0, 0, 0},
};

uint8_t board_actions(void)
{
    return sizeof actions / sizeof actions[0];
}

const char *board_action(uint8_t action)
{
    return actions[action].name;
}

static void check_refusal(void)
{
    size_t bytes = observe(&observed[OBSERVED_BYTES]);

    if (!program_task()->disturbed &&
        memcmp(observed, &observed[OBSERVED_BYTES], bytes) != 0) {
        judge_broken(JUDGE_REFUSED);
    }
}

static bool give(const struct action *action)
{
    switch (action->kind) {
    case KIND_ARM:
        return scene_arm(action->mask, action->argument);
    case KIND_GO:
        return scene_go(action->argument);
    default:
        return scene_order(action->command, action->mask, action->argument);
    }
}

static void order(const struct action *action)
{
    bool permit_was_given = judged.permit_given;

    if (action->command == COMMAND_PERMIT_ON && !board_stopped()) {
        judged.permit_given = true;
    }
    // A token that nobody waits for, or that is another one, is a fault.
    bool may_fault = judged.may_fault;
    judged.may_fault = may_fault || action->argument == SCENE_OTHER_TOKEN;
    (void)observe(observed);
    if (give(action)) {
        if (action->command == COMMAND_STOP || action->command == COMMAND_PERMIT_OFF) {
            judged.permit_given = false;
        }
        return;
    }
    judged.may_fault = judged.may_fault && (may_fault || board_stopped());
    judged.permit_given = judged.permit_given && permit_was_given;
    check_refusal();
}

void board_act(uint8_t action)
{
    const struct action *done = &actions[action];

    switch (done->kind) {
    case KIND_ORDER:
    case KIND_ARM:
    case KIND_GO:
        order(done);
        break;
    case KIND_LINE:
        (void)scene_line(done->mask, LINE_OF_2, 0);
        break;
    case KIND_REFUSED_BLOCK:
        (void)scene_refused_block(done->mask);
        break;
    case KIND_PRESS:
    case KIND_RELEASE:
        scene_press(done->kind == KIND_PRESS);
        break;
    default:
        break;
    }
}
