// SPDX-License-Identifier: MIT
//
// The capture interrupt of the pixel clock: pixel_clock_isr.S.
#include "handlers/handler_twins.h"

#define BUSY          0U // bits of GPIOR0
#define OVERRUN       1U
#define WRAPPED       4U
#define SECOND        5U
#define WRAPPED_TWICE 6U // with one axis
#define BEFORE        6U // with several
#define COUNTING      7U
#define TO_CAPTURE    2U // ACIC of ACSR

// struct capture_queue
#define QUEUE_HEAD     0U
#define QUEUE_TAIL     1U
#define QUEUE_LOST     2U
#define FIRST_LEFT     3U
#define FIRST_TAIL     4U
#define FIRST_IDLE_LOW 5U
#define FIRST_COUNTER  6U
#define FIRST_UNIT     8U
#define QUEUE_ENTRIES  (BOARD_AXES > 1 ? 9U : 6U)
#define EDGES          8U
#define EDGE_BYTES     (BOARD_AXES > 1 ? 7U : 6U)
// struct captured_edge
#define EDGE_TICKS      0U
#define EDGE_TAIL       2U
#define EDGE_LEFT       3U
#define EDGE_IDLE       4U
#define EDGE_NOTES      (EDGE_BYTES - 1U)
#define NOTE_WAS_PARKED 0x40U
#define NOTE_CUT        0x80U

#define PARKED         4U
#define WAIT_MAX_TICKS 22U // that an overflow waits, with one axis

static struct board_timer timer;
static uint16_t queue, overflows;

// A quarter of all bits.
static uint8_t few_bits(void)
{
    uint8_t bits = bench_noise();

    return bits & bench_noise();
}

// What the hardware and the step interrupts change.
static void change(void)
{
    static const uint8_t counts[] = {0, 1, 20, 21, 22, 23, 0x7F, 0x80, 0xFF};
    static const uint8_t registers[] = {
        TIMER_TCNT, TIMER_TCNT + 1U, TIMER_ICR, TIMER_ICR + 1U};

    for (unsigned i = 0; i < sizeof registers; i++) {
        bench_put((uint16_t)(timer.base + registers[i]),
                  counts[bench_noise() % sizeof counts]);
        if ((i & 1U) != 0 && (bench_noise() & 1U) != 0) {
            bench_put((uint16_t)(timer.base + registers[i]), 0);
        }
    }
    bench_put(timer.flags, bench_noise());
    bench_put(TIFR0, bench_noise());
    bench_put(TCNT0, bench_margin());
    for (uint16_t member = TAIL; member < ENGINE_BYTES; member++) {
        bench_put((uint16_t)(timer.engine + member), bench_margin());
    }
    if ((bench_noise() & 1U) != 0) {
        bench_put((uint16_t)(timer.engine + STATE), PARKED);
    }
    bench_put(overflows, bench_margin());
    bench_put(GPIOR0,
              (uint8_t)(bench_get(GPIOR0) ^ (few_bits() & 0xFEU))); // not BUSY
}

static void prepare(void)
{
    change();
    bench_put((uint16_t)(queue + QUEUE_LOST), bench_margin());
    if ((bench_noise() & 3U) != 0) { // some room
        bench_put(
            (uint16_t)(queue + QUEUE_TAIL),
            (uint8_t)(bench_get((uint16_t)(queue + QUEUE_HEAD)) - bench_noise() % 9U));
    }
    bench_put(GPIOR0, few_bits());
    if ((bench_noise() & 7U) != 0) {
        bench_put(GPIOR0, bench_get(GPIOR0) & 0xFEU);
    }
}

static uint8_t engine_reads(uint16_t member)
{
    return twin_reads((uint16_t)(timer.engine + member));
}

static uint8_t *queued(uint16_t member)
{
    return twin_own((uint16_t)(queue + member));
}

static void note_engine(void)
{
    *queued(FIRST_LEFT) = engine_reads(LEFT);
    *queued(FIRST_TAIL) = engine_reads(TAIL);
    *queued(FIRST_IDLE_LOW) = engine_reads(IDLE_COUNT);
    twin_opens();
}

static void restore_temp(void)
{
    twin_writes((uint16_t)(timer.base + TIMER_OCRA + 1U), engine_reads(TRAIN_HIGH));
}

static uint16_t timer_reads(uint16_t offset)
{
    uint8_t low = twin_reads((uint16_t)(timer.base + offset));

    return (uint16_t)(low | twin_reads((uint16_t)(timer.base + offset + 1U)) << 8);
}

#if BOARD_AXES > 1
static void note_at_rest(void)
{
    uint8_t unit = twin_reads(TCNT0);

    twin_opens();
    *queued(FIRST_UNIT) = unit;
    twin_sets(GPIOR0, WRAPPED);
    *queued(FIRST_LEFT) = engine_reads(LEFT);
    *queued(FIRST_TAIL) = engine_reads(TAIL);
    *queued(FIRST_IDLE_LOW) = engine_reads(IDLE_COUNT);
}

static void begin(void)
{
    if (!twin_has(timer.flags, OVERFLOW)) {
        note_engine();
        return;
    }
    twin_put_word((uint16_t)(queue + FIRST_COUNTER), timer_reads(TIMER_TCNT));
    restore_temp();
    if (twin_has(GPIOR0, BEFORE)) {
        note_engine();
    } else if ((engine_reads(STATE) & PARKED) != 0) {
        note_at_rest();
    } else {
        note_engine();
        twin_sets(GPIOR0, WRAPPED);
    }
}

static uint8_t periods_back(uint16_t ticks)
{
    return !twin_has(GPIOR0, WRAPPED) ||
           twin_word((uint16_t)(queue + FIRST_COUNTER)) < ticks;
}

// The coarse clock's low 16 bits.
static uint16_t clock_units(void)
{
    twin_closes();
    uint8_t low = twin_reads(TCNT0);
    bool wrapped = twin_has(TIFR0, OVERFLOW);
    wrapped |= twin_has(GPIOR0, COUNTING);
    uint8_t high = twin_reads(overflows);
    twin_opens();
    high = (uint8_t)(high + (wrapped && low < 0x80U));
    if (twin_has(GPIOR0, WRAPPED)) {
        high = (uint8_t)(high - (low < *queued(FIRST_UNIT)));
        low = *queued(FIRST_UNIT);
    }
    return (uint16_t)(high << 8 | low);
}
#else
static void let_overflow_in(void)
{
    twin_opens();
    twin_closes();
}

static void begin(void)
{
    if (twin_has(timer.flags, OVERFLOW)) {
        let_overflow_in();
        if (twin_has(timer.flags, OVERFLOW)) {
            let_overflow_in();
            twin_sets(GPIOR0, WRAPPED_TWICE);
        }
        twin_sets(GPIOR0, WRAPPED);
    }
    note_engine();
}

static uint8_t periods_back(uint16_t ticks)
{
    unsigned back = 1;

    if (twin_has(GPIOR0, WRAPPED)) {
        back += twin_has(GPIOR0, WRAPPED_TWICE) ? 1U : 0U;
        back += ticks >= WAIT_MAX_TICKS ? 1U : 0U;
    }
    return (uint8_t)back;
}

// Of a seek: this very moment, in m.
static uint16_t count_now(void)
{
    twin_closes();
    uint16_t count = timer_reads(TIMER_TCNT);
    while (twin_has(timer.flags, OVERFLOW)) {
        let_overflow_in();
        count = timer_reads(TIMER_TCNT);
    }
    restore_temp();
    note_engine();
    twin_clears(GPIOR0, WRAPPED);
    return count;
}
#endif

static uint8_t left_or_cut(uint8_t *notes)
{
    uint8_t left = *queued(FIRST_LEFT);

    if (left == 0 && engine_reads(TAIL) == *queued(FIRST_TAIL)) {
        left = engine_reads(CUT);
        if (left != 0) {
            *notes |= NOTE_CUT;
        }
    }
    return left;
}

static void queue_edge(uint16_t entry, uint16_t ticks, uint16_t idle_now)
{
    uint8_t notes = periods_back(ticks);

    twin_put_word((uint16_t)(entry + EDGE_TICKS), ticks);
    *twin_own((uint16_t)(entry + EDGE_TAIL)) = *queued(FIRST_TAIL);
    *twin_own((uint16_t)(entry + EDGE_LEFT)) = left_or_cut(&notes);
#if BOARD_AXES > 1
    uint8_t high =
        (uint8_t)((idle_now >> 8) - ((idle_now & 0xFFU) < *queued(FIRST_IDLE_LOW)));
    uint16_t idle = (uint16_t)(high << 8 | *queued(FIRST_IDLE_LOW));
    if (engine_reads(STATE) == PARKED) {
        idle = clock_units();
        notes = NOTE_WAS_PARKED;
    }
    twin_put_word((uint16_t)(entry + EDGE_IDLE), idle);
#else
    (void)idle_now;
    *twin_own((uint16_t)(entry + EDGE_IDLE)) = *queued(FIRST_IDLE_LOW);
#endif
    *twin_own((uint16_t)(entry + EDGE_NOTES)) = notes;
    *queued(QUEUE_HEAD) += 1U;
}

static void take_edge(void)
{
    uint8_t head = *queued(QUEUE_HEAD);

    if ((uint8_t)(*queued(QUEUE_TAIL) - head) == (uint8_t)-EDGES) {
        if (*queued(QUEUE_LOST) != 0xFFU) {
            *queued(QUEUE_LOST) += 1U;
        }
        return;
    }
    twin_closes();
    uint16_t ticks = timer_reads(TIMER_ICR);
    uint16_t idle_now = 0;

    restore_temp();
    if (BOARD_AXES > 1) {
        idle_now = engine_reads(IDLE_COUNT);
        idle_now |= (uint16_t)(engine_reads(IDLE_COUNT + 1U) << 8);
    }
    bool is_second = twin_has(timer.flags, CAPTURED);
    twin_opens();
    if (is_second || twin_has(GPIOR0, SECOND)) {
#if BOARD_AXES > 1
        return;
#else
        if (!twin_has(ACSR, TO_CAPTURE)) {
            return;
        }
        ticks = count_now();
#endif
    }
    queue_edge(
        (uint16_t)(queue + QUEUE_ENTRIES + head % EDGES * EDGE_BYTES), ticks, idle_now);
}

static void capture(void)
{
    if (twin_has(GPIOR0, BUSY)) {
        twin_sets(GPIOR0, OVERRUN);
        twin_sets(GPIOR0, SECOND);
        return;
    }
    twin_sets(GPIOR0, BUSY);
    begin();
    take_edge();
    twin_clears(GPIOR0, WRAPPED);
    if (BOARD_AXES == 1) {
        twin_clears(GPIOR0, WRAPPED_TWICE);
    }
    twin_closes();
    if (BOARD_AXES > 1) {
        twin_clears(GPIOR0, BEFORE);
    }
    twin_clears(GPIOR0, SECOND);
    twin_clears(GPIOR0, BUSY);
}

void run_clock_handler(unsigned runs)
{
    static const struct made_up nobody[] = {{.function = 0}};
    struct shared_memory shared[3] = {{0, 0}};

    timer = board_timer(BOARD_PIXEL_CLOCK_AXIS);
    queue = bench_variable("pixel_clock_edges");
    overflows = bench_variable("clock_overflows");
    shared[0] = (struct shared_memory){timer.engine, ENGINE_BYTES};
    shared[1] = (struct shared_memory){overflows, 1};
    bench_run(&(struct handler){.name = "pixel clock",
                                .vector = VECTOR_CAPTURE,
                                .shared = shared,
                                .made_up = nobody,
                                .prepare = prepare,
                                .interrupt = change,
                                .twin = capture},
              runs);
}
