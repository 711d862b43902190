// SPDX-License-Identifier: MIT
// Any bytes on the bus, through the frame parser into the server and back. After any input this
// must hold:
//
//   * bytes that are taken for a frame have its address, length and checksum; bytes that end with a
//     silence and have a right checksum are never dropped; a foreign or a damaged frame is never
//     served
//   * the reply is, byte for byte, the reply of the reference; there is no reply to a broadcast and
//     none in listen-only mode
//   * a broadcast leaves the bytes that follow it as they are
//   * the registers are those of the reference: a request that fails changes nothing
//   * after a silence a valid request is answered
#include <stdlib.h>
#include <string.h>

#include "form.h"
#include "model.h"
#include "promise.h"
#include "reference.h"
#include "script.h"
#include "target.h"
#include "wire/frame.h"
#include "wire/server.h"
#include "wire/server_data.h"

// The board's end of the bus, driven as app/bus/bus_port.c drives it, and a copy of the bytes
// received.
struct line {
    struct frame *frame;
    struct server_counters counters;
    uint8_t received[FRAME_MAX_BYTES];
    bool lazy;    // the main loop does not look before the silence
    bool pending; // a request is complete; it is served at the next silence
    unsigned replies;
};

// Compare the parser's verdict with the bytes that it was given.
static void check_front(const struct line *line, enum frame_status status, bool ended)
{
    const struct frame *frame = line->frame;
    uint8_t first = line->received[0];
    bool ours = first == 0 || first == SCRIPT_ADDRESS;

    promise(frame->length <= frame->received, "a frame longer than what came");
    promise(memcmp(frame->bytes, line->received, frame->received) == 0,
            "other bytes than came");
    if (status == FRAME_BAD) {
        promise(ended && frame->length == frame->received, "bad before the silence");
        promise(frame->length < 4 || script_crc(line->received, frame->length) != 0,
                "a whole frame is bad");
        return;
    }
    promise(status == (ours ? FRAME_READY : FRAME_FOREIGN), "taken for another's");
    promise(frame->length >= 4, "a frame of %u bytes", (unsigned)frame->length);
    promise(script_crc(line->received, frame->length) == 0,
            "ready without being a frame");
}

// Drop the frame at the front of the buffer.
static void drop(struct line *line)
{
    struct frame *frame = line->frame;
    uint16_t left = (uint16_t)(frame->received - frame->length);

    memmove(frame->bytes, &frame->bytes[frame->length], left);
    memmove(line->received, &line->received[frame->length], left);
    frame->received = left;
}

static void check_world(const struct model *wanted, const struct model *before)
{
    promise(model_same(&model, wanted),
            "%s",
            model_same(&model, before) ? "a write was not done"
                                       : "the registers are not what they should be");
}

static void check_reply(struct line *line,
                        const struct frame *request,
                        const struct expected *expected,
                        uint16_t count)
{
    struct frame *frame = line->frame;
    uint16_t exact = (uint16_t)(expected->count - (expected->counted ? 2u : 0u));

    promise(count == expected->count,
            "%u bytes of reply, %u expected",
            (unsigned)count,
            (unsigned)expected->count);
    promise(memcmp(frame->bytes, expected->bytes, exact) == 0, "another reply");
    if (count != 0) {
        uint16_t sealed = frame_seal(frame, count);
        promise(sealed <= FRAME_MAX_BYTES, "a reply of %u bytes", (unsigned)sealed);
        form_check(request->bytes, frame->bytes, sealed);
        line->replies++;
    }
}

static void serve(struct line *line)
{
    struct frame *frame = line->frame;
    struct frame request = *frame;
    struct model before = model;
    struct model wanted = model;
    struct expected expected;

    wanted.listen_only = line->counters.listen_only;
    before.listen_only = wanted.listen_only;
    reference_serve(request.bytes, (uint16_t)(request.length - 2u), &wanted, &expected);
    uint16_t count = server_serve(frame, &line->counters);

    model.listen_only = line->counters.listen_only;
    check_world(&wanted, &before);
    if (request.bytes[0] == 0) {
        promise(memcmp(&frame->bytes[request.length],
                       &request.bytes[request.length],
                       FRAME_MAX_BYTES - request.length) == 0,
                "a request to all spoilt what follows it");
    }
    check_reply(line, &request, &expected, count);
    frame->length = request.length;
}

// Let the parser look as long as it finds frames.
static void look(struct line *line, bool ended)
{
    while (!line->pending) {
        enum frame_status status = frame_look(line->frame, ended, SCRIPT_ADDRESS);
        if (status == FRAME_PARTIAL) {
            promise(!ended || line->frame->received == 0, "silence ended nothing");
            return;
        }
        check_front(line, status, ended);
        if (status == FRAME_READY && line->received[0] != 0) {
            line->pending = true;
            return;
        }
        if (status == FRAME_READY) {
            serve(line);
        }
        drop(line);
    }
}

// Receive a byte. A request to this board alone disables reception until its reply has left.
static void take_byte(struct line *line, uint8_t byte)
{
    struct frame *frame = line->frame;

    if (line->pending || frame->received == FRAME_MAX_BYTES) {
        return;
    }
    frame->bytes[frame->received] = byte;
    line->received[frame->received] = byte;
    frame->received++;
    if (!line->lazy) {
        look(line, false);
    }
}

static void silence(struct line *line)
{
    look(line, true);
    if (line->pending) {
        serve(line);
        line->frame->received = 0;
        frame_reset(line->frame);
    }
    line->pending = false;
}

static void send(struct line *line, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        take_byte(line, bytes[i]);
    }
}

static void ask(struct line *line, const uint8_t *scripted, size_t count)
{
    struct script script = {.data = scripted, .left = count};
    struct script_item item;

    (void)script_next(&script, &item);
    send(line, item.bytes, item.count);
    silence(line);
}

// End listen-only mode, then read one word, of which the reference knows the value.
static void probe(struct line *line)
{
    static const uint8_t restart[] = {SCRIPT_REQUEST, 5, 8, 0, 1, 0, 0};
    static const uint8_t read[] = {SCRIPT_REQUEST, 5, 3, 0, 0, 0, 1};

    silence(line);
    if (line->counters.listen_only) {
        ask(line, restart, sizeof restart);
    }
    unsigned before = line->replies;
    ask(line, read, sizeof read);
    promise(line->replies == before + 1u, "a valid request was not answered");
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
    line->lazy = item->seen_late;
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

    // The frame is on the heap, so that the address sanitizer sees a write behind it.
    line.frame = calloc(1, sizeof *line.frame);
    if (line.frame == NULL) {
        return -1;
    }
    frame_reset(line.frame);
    model_reset();
    while (script_next(&script, &item)) {
        play(&line, &item);
    }
    probe(&line);
    free(line.frame);
    return 0;
}
