// SPDX-License-Identifier: MIT

#include "pty.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "cpu_clock.h"

// A millisecond or less: bytes are passed on and time is kept in such steps.
#define SLICE_CYCLES 16000U
#define CHUNK        256

// What is sent while a board starts is lost, so the terminal is offered once it has.
#define START_MS 300U

// How far the simulation may be behind the PC's clock and still catch up by running faster.
#define CATCH_UP_S 0.05

static int open_pty(void)
{
    int master = posix_openpt(O_RDWR | O_NOCTTY);
    struct termios raw;
    int slave;

    if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) {
        return -1;
    }
    // This program keeps the slave open: otherwise reads fail until a client opens it.
    slave = open(ptsname(master), O_RDWR | O_NOCTTY);
    if (slave < 0 || tcgetattr(slave, &raw) != 0) {
        return -1;
    }
    cfmakeraw(&raw);
    (void)tcsetattr(slave, TCSANOW, &raw);
    (void)fcntl(master, F_SETFL, O_NONBLOCK);
    return master;
}

// When the simulation would have had to start to be at the present cycle now.
static double start_for_now_s(const struct bench *bench)
{
    return bench_wall_s() - (double)bench->cycle / cpu_clock_hz();
}

bool pty_open(struct pty *pty, struct bench *bench)
{
    pty->bench = bench;
    pty->lost_cycles = 0;
    pty->master = open_pty();
    if (pty->master < 0) {
        return false;
    }
    pty->started_s = start_for_now_s(bench);
    return true;
}

bool pty_is_open(const struct pty *pty)
{
    return pty->bench != NULL;
}

const char *pty_name(const struct pty *pty)
{
    return ptsname(pty->master);
}

void pty_close(struct pty *pty)
{
    if (pty_is_open(pty)) {
        (void)close(pty->master);
        pty->bench = NULL;
    }
}

static void pass_in(const struct pty *pty)
{
    uint8_t bytes[CHUNK];
    ssize_t count = read(pty->master, bytes, sizeof bytes);

    if (count > 0) {
        (void)bus_master_send(&pty->bench->bus, bytes, (size_t)count, pty->bench->cycle);
    }
}

static void pass_out(const struct pty *pty)
{
    uint64_t end;
    int byte;

    while ((byte = bus_master_receive(&pty->bench->bus, pty->bench->cycle, &end)) >= 0) {
        uint8_t one = (uint8_t)byte;

        (void)!write(
            pty->master, &one, 1); // a full terminal loses bytes, as a real one does
    }
}

// A busy PC may hold the simulation up: the time that is lost then stays lost, because on a board
// that runs faster for a while every timeout of the bus would come too early.
static void keep_pace(struct pty *pty)
{
    double ahead_s = pty->started_s - start_for_now_s(pty->bench);

    if (ahead_s < -CATCH_UP_S) {
        pty->lost_cycles += (uint64_t)(-ahead_s * cpu_clock_hz());
        pty->started_s = start_for_now_s(pty->bench);
    }
    if (ahead_s > 0.0) {
        struct timespec pause = {.tv_sec = (time_t)ahead_s};

        pause.tv_nsec = (long)((ahead_s - (double)pause.tv_sec) * 1e9);
        (void)nanosleep(&pause, NULL);
    }
}

bool pty_run(struct pty *pty, uint64_t cycle)
{
    struct bench *bench = pty->bench;
    bool alive = true;

    while (alive && bench->cycle < cycle) {
        uint64_t left = cycle - bench->cycle;

        pass_in(pty);
        alive =
            bench_run(bench, bench->cycle + (left < SLICE_CYCLES ? left : SLICE_CYCLES));
        pass_out(pty);
        keep_pace(pty);
    }
    return alive;
}

int pty_serve(struct bench *bench, const volatile int *stop)
{
    struct pty pty = {0};
    bool alive = bench_run(bench, cpu_clock_cycles_of_ms(START_MS));

    if (!pty_open(&pty, bench)) {
        (void)fprintf(stderr, "pixstep-sim: no pseudo terminal: %s\n", strerror(errno));
        return 2;
    }
    (void)printf("%s\n", pty_name(&pty));
    (void)fflush(stdout);
    while (alive && !*stop) {
        alive = pty_run(&pty, bench->cycle + SLICE_CYCLES);
    }
    pty_close(&pty);
    return alive ? 0 : 1;
}
