// SPDX-License-Identifier: MIT
// The actions of the host, and those of a hand at the emergency stop.
#include <string.h>

#include "app/axes/permit.h"
#include "app/axes/reference.h"
#include "app/axes/token.h"
#include "app/motion/seek.h"
#include "app/watch/drivers.h"
#include "explore/board.h"
#include "explore/judge.h"
#include "explore/judged.h"
#include "explore/part.h"
#include "explore/program.h"
#include "explore/scene.h"

// Room for everything that a refused order must leave as it was, compared byte by byte.
#define OBSERVED_BYTES 4096u // room; observe() says how many they are

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

    seen = note(seen, axes_get(0), sizeof(struct axis));
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
    seen = note(seen, &part.timers[0].buffer_top, sizeof part.timers[0].buffer_top);
    seen = note(seen, &part.timers[0].buffer_edge, sizeof part.timers[0].buffer_edge);
    seen = note(seen, &permit, sizeof permit);
    return (size_t)(seen - to);
}

enum kind {
    KIND_ORDER,
    KIND_GOOD_BLOCK,
    KIND_MORE,
    KIND_REFUSED_BLOCK,
    KIND_PRESS,
    KIND_RELEASE,
    KIND_NOTHING
};

struct action {
    const char *name;
    uint8_t kind;
    uint8_t command;
    uint8_t argument;
};

static const struct action actions[] = {
    {"nothing", KIND_NOTHING, 0, 0},
    {"arm", KIND_ORDER, COMMAND_ARM, 0},
    {"arm with a token", KIND_ORDER, COMMAND_ARM, SCENE_TOKEN},
    {"go", KIND_ORDER, COMMAND_GO, SCENE_TOKEN},
    {"go with another token", KIND_ORDER, COMMAND_GO, SCENE_OTHER_TOKEN},
    {"disarm", KIND_ORDER, COMMAND_DISARM, 0},
    {"stop", KIND_ORDER, COMMAND_STOP, 0},
    {"discard", KIND_ORDER, COMMAND_DISCARD, 0},
    {"clear fault", KIND_ORDER, COMMAND_CLEAR_FAULT, 0},
    {"enable", KIND_ORDER, COMMAND_ENABLE, 0},
    {"disable", KIND_ORDER, COMMAND_DISABLE, 0},
    {"zero", KIND_ORDER, COMMAND_ZERO, 0},
    {"permit on", KIND_ORDER, COMMAND_PERMIT_ON, 0},
    {"permit off", KIND_ORDER, COMMAND_PERMIT_OFF, 0},
    {"a block", KIND_GOOD_BLOCK, 0, 0},
    {"more of a streamed line", KIND_MORE, 0, 0},
    {"a block that is refused", KIND_REFUSED_BLOCK, 0, 0},
    {"press the emergency stop", KIND_PRESS, 0, 0},
    {"release the emergency stop", KIND_RELEASE, 0, 0},
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

static void order(const struct action *action)
{
    struct judged was = judged;
    bool arms = action->command == COMMAND_ARM;

    if (arms) {
        judged.edges_allowed = JUDGE_ANY_NUMBER;
    }
    if (action->command == COMMAND_PERMIT_ON && !board_stopped()) {
        judged.permit_given = true;
    }
    (void)observe(observed);
    if (scene_order(action->command, action->argument)) {
        if (action->command == COMMAND_STOP || action->command == COMMAND_PERMIT_OFF) {
            judged.permit_given = false;
        }
        return;
    }
    if (arms && judged.edges_allowed > was.edges_allowed) {
        judged.edges_allowed = was.edges_allowed;
    }
    judged.permit_given = judged.permit_given && was.permit_given;
    check_refusal();
}

void board_act(uint8_t action)
{
    const struct action *done = &actions[action];

    switch (done->kind) {
    case KIND_ORDER:
        order(done);
        break;
    case KIND_GOOD_BLOCK:
        (void)BLOCK(START(0), {2, 1}, END);
        break;
    case KIND_MORE:
        (void)BLOCK({2, 1});
        break;
    case KIND_REFUSED_BLOCK:
        (void)BLOCK({0x0FFF, 0});
        break;
    case KIND_PRESS:
    case KIND_RELEASE:
        scene_press(done->kind == KIND_PRESS);
        break;
    default:
        break;
    }
}
