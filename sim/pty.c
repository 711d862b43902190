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

static void pass_in(struct bench *bench, int master)
{
    uint8_t bytes[CHUNK];
    ssize_t count = read(master, bytes, sizeof bytes);

    if (count > 0) {
        (void)bus_master_send(&bench->bus, bytes, (size_t)count, bench->cycle);
    }
}

static void pass_out(struct bench *bench, int master)
{
    uint64_t end;
    int byte;

    while ((byte = bus_master_receive(&bench->bus, bench->cycle, &end)) >= 0) {
        uint8_t one = (uint8_t)byte;

        (void)!write(master, &one, 1); // a full terminal loses bytes, as a real one does
    }
}

// When the simulation would have had to start to be at the present cycle now.
static double start_for_now_s(const struct bench *bench)
{
    return bench_wall_s() - (double)bench->cycle / cpu_clock_hz();
}

// A busy PC may hold the simulation up: the time that is lost then stays lost, because on a board
// that runs faster for a while every timeout of the bus would come too early.
static void keep_pace(const struct bench *bench, double *started_s)
{
    double ahead_s = *started_s - start_for_now_s(bench);

    if (ahead_s < -CATCH_UP_S) {
        *started_s = start_for_now_s(bench);
    }
    if (ahead_s > 0.0) {
        struct timespec pause = {.tv_sec = (time_t)ahead_s};

        pause.tv_nsec = (long)((ahead_s - (double)pause.tv_sec) * 1e9);
        (void)nanosleep(&pause, NULL);
    }
}

int pty_serve(struct bench *bench, const volatile int *stop)
{
    int master = open_pty();
    double started_s;
    bool alive = true;

    if (master < 0) {
        (void)fprintf(stderr, "pixstep-sim: no pseudo terminal: %s\n", strerror(errno));
        return 2;
    }
    alive = bench_run(bench, cpu_clock_cycles_of_ms(START_MS));
    started_s = start_for_now_s(bench);
    (void)printf("%s\n", ptsname(master));
    (void)fflush(stdout);
    while (alive && !*stop) {
        pass_in(bench, master);
        alive = bench_run(bench, bench->cycle + SLICE_CYCLES);
        pass_out(bench, master);
        keep_pace(bench, &started_s);
    }
    (void)close(master);
    return alive ? 0 : 1;
}
