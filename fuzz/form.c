// SPDX-License-Identifier: MIT
#include "form.h"

#include <string.h>

#include "promise.h"
#include "script.h"

static void check_exception(const uint8_t *reply, uint16_t reply_count)
{
    promise(reply_count == 5, "an exception of %u bytes", (unsigned)reply_count);
    promise(reply[2] >= 1 && reply[2] <= 6, "exception code %u", (unsigned)reply[2]);
}

static void check_counted(const uint8_t *reply, uint16_t reply_count, unsigned wanted)
{
    promise(reply[2] == wanted, "byte count %u, not %u", (unsigned)reply[2], wanted);
    promise(reply_count == 5u + wanted, "%u bytes in all", (unsigned)reply_count);
}

static void check_echo(const uint8_t *request,
                       const uint8_t *reply,
                       uint16_t reply_count,
                       uint16_t wanted)
{
    promise(reply_count == wanted && memcmp(request, reply, wanted - 2u) == 0,
            "not the request's echo");
}

// The number of bytes of a reply that repeats a write, with its checksum; 0: another kind of reply.
static uint16_t echo_bytes(uint8_t function)
{
    switch (function) {
    case 5:
    case 6:
    case 15:
    case 16:
        return 8;
    case 22:
        return 10;
    default:
        return 0;
    }
}

static void check_body(const uint8_t *request, const uint8_t *reply, uint16_t reply_count)
{
    uint8_t function = request[1];
    unsigned number = request[4] * 256u + request[5];

    if (function == 1 || function == 2) {
        check_counted(reply, reply_count, (number + 7u) / 8u);
    } else if (function == 3 || function == 4 || function == 23) {
        check_counted(reply, reply_count, 2u * number);
    } else if (function == 17) {
        check_counted(reply, reply_count, reply_count - 5u);
        promise(
            reply[4] == 0 || reply[4] == 0xFF, "run indicator %u", (unsigned)reply[4]);
    } else if (echo_bytes(function) != 0) {
        check_echo(request, reply, reply_count, echo_bytes(function));
    }
}

void form_check(const uint8_t *request, const uint8_t *reply, uint16_t reply_count)
{
    promise(reply_count >= 5 && reply_count <= 256,
            "a reply of %u bytes",
            (unsigned)reply_count);
    promise(script_crc(reply, reply_count) == 0, "a reply with a wrong checksum");
    promise(reply[0] == request[0], "a reply by address %u", (unsigned)reply[0]);
    if (reply[1] == (request[1] | 0x80u) && (request[1] & 0x80u) == 0) {
        check_exception(reply, reply_count);
    } else if (reply[1] == request[1] && reply_count == 5 && reply[2] == 1 &&
               (request[1] & 0x80u) != 0) {
        // An exception to a function code that has the exception bit itself.
    } else {
        promise(reply[1] == request[1], "function %u answered", (unsigned)reply[1]);
        check_body(request, reply, reply_count);
    }
}
