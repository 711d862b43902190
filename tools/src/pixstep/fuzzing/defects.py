# SPDX-License-Identifier: MIT
"""Defects that the fuzzers must find: what would be wrong if a check were not there.

Each is planted in a copy of one source file; the tree itself never holds them.
"""

from pixstep.fuzzing.sources import Defect

FRAME = "core/wire/frame.c"
SERVER = "core/wire/server.c"

DEFECTS = (
    Defect(
        "server",
        FRAME,
        "if (frame->length == FRAME_MAX_BYTES) {",
        "if (frame->length > FRAME_MAX_BYTES) {",
        "one byte more than the frame holds",
    ),
    Defect(
        "server",
        SERVER,
        "#define READ_MAX_WORDS  125u",
        "#define READ_MAX_WORDS  127u",
        "a reply longer than a frame",
    ),
    Defect(
        "server",
        SERVER,
        "bytes[6] != 2u * count ||",
        "",
        "a byte count that is believed",
    ),
    Defect(
        "server",
        SERVER,
        "if (broadcast) {\n        return 0;",
        "if (broadcast && reply_bytes == 0) {\n        return 0;",
        "a broadcast that is answered",
    ),
    Defect(
        "server",
        FRAME,
        "|| crc16(frame->bytes, frame->length) != 0",
        "|| (frame->length < 8 && crc16(frame->bytes, frame->length) != 0)",
        "a checksum that only short frames need",
    ),
    Defect(
        "server",
        FRAME,
        "if (status != FRAME_READY) {\n        frame_reset(frame);",
        "if (status == FRAME_BAD) {\n        frame_reset(frame);",
        "silence that does not end a foreign frame",
    ),
    Defect(
        "board",
        "app/data.c",
        "for (uint16_t i = 0; i < count; i++) {\n        (void)settings_set(&wanted",
        "for (uint16_t i = 0; i < count; i++) {\n        (void)settings_set("
        "&machine.settings, (uint16_t)(address + i), get_word(&words[2u * i]));\n"
        "        (void)settings_set(&wanted",
        "settings that are written before they are checked",
    ),
    Defect(
        "board",
        "app/data.c",
        "if (axis >= CONFIG_AXES) {",
        "if (axis > CONFIG_AXES) {",
        "a block for an axis behind the last",
    ),
)
