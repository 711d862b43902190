// SPDX-License-Identifier: MIT
// Anything at all on the serial line, through the frame parser into the server and back. What must
// hold, whatever came:
//
//   * a frame is ready exactly when what came since the last silence is one: address, length,
//     checksum; never for a foreign or a spoilt one
//   * the reply is, byte for byte, what the reference works out; none to a broadcast
//   * the registers are what the reference makes of them: a request that fails changes nothing
//   * after any input and a silence a valid request is answered
#include <stdlib.h>
#include <string.h>

#include "fail.h"
#include "form.h"
#include "model.h"
#include "reference.h"
#include "script.h"
#include "wire/frame.h"
#include "wire/server.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// The board's side of the line, as serial.c drives it; what came since the last silence beside it.
struct line {
    struct frame *frame;
    struct server_counters counters;
    uint8_t since_silence[FRAME_MAX_BYTES];
    size_t count; // may be more than is kept
    bool pending; // a request is complete; it is served at the next silence
    unsigned replies;
};

static void check_ready(const struct line *line)
{
    const struct frame *frame = line->frame;

    PROMISE(frame->length == line->count, "%u bytes ready", (unsigned)frame->length);
    PROMISE(memcmp(frame->bytes, line->since_silence, frame->length) == 0,
            "other bytes than came");
    PROMISE(script_is_frame(line->since_silence, line->count, SCRIPT_ADDRESS),
            "ready without being a frame for this board");
}

static void take_byte(struct line *line, uint8_t byte)
{
    if (line->pending) {
        return;
    }
    if (line->count < FRAME_MAX_BYTES) {
        line->since_silence[line->count] = byte;
    }
    line->count++;
    if (frame_byte(line->frame, byte, SCRIPT_ADDRESS) == FRAME_READY) {
        check_ready(line);
        line->pending = true;
    }
}

static void check_reply(const struct line *line,
                        const uint8_t *request,
                        uint16_t request_count,
                        uint16_t reply_count)
{
    struct frame *frame = line->frame;
    uint16_t sealed = frame_seal(frame, reply_count);

    PROMISE(sealed <= FRAME_MAX_BYTES, "a reply of %u bytes", (unsigned)sealed);
    form_check(request, request_count, frame->bytes, sealed);
}

static void serve(struct line *line)
{
    struct frame *frame = line->frame;
    struct frame request = *frame;
    struct model before = model;
    struct model wanted = model;
    struct expected expected;

    reference_serve(
        request.bytes, (uint16_t)(request.length - 2u), &wanted, &expected);
    uint16_t count = server_serve(frame, &line->counters);

    PROMISE(frame->length == request.length, "the server changed the frame's length");
    PROMISE(memcmp(&model, &wanted, sizeof model) == 0,
            memcmp(&model, &before, sizeof model) == 0 ? "a write was not done"
                                                       : "the registers are wrong");
    PROMISE((count != 0) == (expected.count != 0 || !expected.exact),
            "%u bytes of reply, %u expected",
            (unsigned)count,
            (unsigned)expected.count);
    if (expected.exact) {
        PROMISE(count == expected.count, "a reply of %u bytes", (unsigned)count);
        PROMISE(memcmp(frame->bytes, expected.bytes, count) == 0, "another reply");
    }
    if (count != 0) {
        check_reply(line, request.bytes, request.length, count);
        line->replies++;
    }
    frame_reset(frame);
}

static void silence(struct line *line)
{
    if (!line->pending) {
        bool whole = line->count <= FRAME_MAX_BYTES &&
                     script_is_frame(line->since_silence, line->count, SCRIPT_ADDRESS);
        line->pending = frame_silence(line->frame, SCRIPT_ADDRESS) == FRAME_READY;
        PROMISE(line->pending == whole,
                whole ? "a frame was not recognised" : "ready without being a frame");
    }
    if (line->pending) {
        serve(line);
    }
    line->pending = false;
    line->count = 0;
}

static void send(struct line *line, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        take_byte(line, bytes[i]);
    }
}

// Reads one word; the reference knows the answer.
static void probe(struct line *line)
{
    static const uint8_t pdu[] = {
        SCRIPT_REQUEST, 5, 3, 0, 0, 0, 1}; // one word, read from address 0
    struct script script = {.data = pdu, .left = sizeof pdu};
    struct script_item item;

    silence(line);
    unsigned before = line->replies;
    (void)script_next(&script, &item);
    send(line, item.bytes, item.count);
    silence(line);
    PROMISE(line->replies == before + 1u, "a valid request was not answered");
}

static void play(struct line *line, const struct script_item *item)
{
    if (item->kind == SCRIPT_PROBE) {
        probe(line);
        return;
    }
    if (item->kind == SCRIPT_SILENCE || (item->count != 0 && item->silence_before)) {
        silence(line);
    }
    send(line, item->bytes, item->count);
    if (item->count != 0 && item->silence_after) {
        silence(line);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct script script = {.data = data, .left = size};
    struct script_item item;
    struct line line = {0};

    // On the heap, so that the address sanitizer sees a write behind it.
    line.frame = calloc(1, sizeof *line.frame);
    PROMISE(line.frame != NULL, "no memory");
    frame_reset(line.frame);
    model_reset();
    while (script_next(&script, &item)) {
        play(&line, &item);
    }
    probe(&line);
    free(line.frame);
    return 0;
}
