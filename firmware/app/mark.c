// SPDX-License-Identifier: MIT
#include "app/mark.h"

#if FEATURE_TOKENS

#include "app/reference.h"  // reference_*
#include "app/time_check.h" // time_check_now_ticks
#include "hal/uart.h"       // uart_age_ticks

static struct mark mark;
static bool due; // mark.ticks is the time of the command's end

const struct mark *mark_now(void)
{
    return &mark;
}

void mark_set(void)
{
    mark.ticks = (int32_t)(time_check_now_ticks() - uart_age_ticks());
    due = true;
}

void mark_poll(void)
{
    if (!due) {
        return;
    }
    due = false;
    mark.ticks =
        reference_present() ? mark.ticks - (int32_t)reference_number_ticks() : MARK_RESTS;
    mark.edge = reference_number();
    mark.count++;
    mark.steady = true;
}

void mark_disturb(void)
{
    mark.steady = false;
}

void mark_zero(uint16_t edge)
{
    mark.zero_edge = edge;
}

#endif
