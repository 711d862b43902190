// SPDX-License-Identifier: MIT
#include "app/bus/traffic.h"

#include "hal/clock.h" // clock_now_ms

static struct server_counters bus_counters;
static uint16_t last_request_ms;

void traffic_start(void)
{
    bus_counters = (struct server_counters){0};
    last_request_ms = clock_now_ms();
}

struct server_counters *traffic_counters(void)
{
    return &bus_counters;
}

void traffic_count_overruns(uint8_t bytes)
{
    bus_counters.rx_overruns = (uint16_t)(bus_counters.rx_overruns + bytes);
}

void traffic_note_request(void)
{
    last_request_ms = clock_now_ms();
}

uint16_t traffic_last_request_ms(void)
{
    return last_request_ms;
}
