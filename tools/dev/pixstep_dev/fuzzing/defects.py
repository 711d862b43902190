# SPDX-License-Identifier: MIT
"""Defects that the fuzzers must find: what would be wrong if a check were not there.

Each is planted in a copy of one source file; the tree itself never holds them.
"""

from pixstep_dev.fuzzing.sources import Defect

FRAME = "core/wire/frame.c"
SERVER = "core/wire/server.c"

DEFECTS = (
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
        "byte_count != (uint8_t)(2u * count)",
        "false",
        "a byte count that is believed",
    ),
    Defect(
        "server",
        SERVER,
        "bool mute = server_listens_only(counters) || bytes[0] == 0;",
        "bool mute = server_listens_only(counters);",
        "a request to all that is answered",
    ),
    Defect(
        "server",
        SERVER,
        "exception = check_range(address, count, READ_HOLDING);",
        "exception = MODBUS_OK;",
        "a write that is done though the read is impossible",
    ),
    Defect(
        "server",
        SERVER,
        "return data_write(address, 1, &bytes[8]);",
        "bytes[10] = 0;\n    return data_write(address, 1, &bytes[8]);",
        "a request to all that spoils what follows",
    ),
    Defect(
        "server",
        FRAME,
        "return checksum(frame, length) == 0;",
        "return length > 8u || checksum(frame, length) == 0;",
        "a checksum that only short frames need",
    ),
    Defect(
        "server",
        FRAME,
        "(ended && ends_at(frame, received))",
        "(ended && received > 8u && ends_at(frame, received))",
        "a frame of unknown form that silence does not end",
    ),
    Defect(
        "board",
        "app/registers/data.c",
        "    } else {\n        settings_exchange(address, count, words);\n    }\n",
        "    }\n",
        "settings that stay as they must not be",
    ),
)
