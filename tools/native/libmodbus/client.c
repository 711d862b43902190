// SPDX-License-Identifier: MIT
// The conformance list by libmodbus, on a serial port or pseudo terminal:
//
//     pixstep-libmodbus PORT BOARD ID AXES HZ     its name, number, axes, ticks a second
//
// Standard output begins with a row that has the board's register `features`. A row for each case
// follows: the name of the case (as in robustness/clients/cases.py), a tab, and then "ok",
// "exception 01" if the board does not serve the function that the case needs, or what is wrong.
// Cases that libmodbus cannot send are not in its list.
#include <errno.h>
#include <modbus.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNIT        1
#define PATIENCE_S  30 // a busy PC may hold the simulated board up
#define OUTPUTS     0x0061
#define STATUS      0x0004
#define PERIOD      0x0014
#define FEATURES    0x0068
#define RECORDS     0x0100
#define SETTINGS    27
#define PIXEL_HZ    2
#define DIR_SETUP   6
#define DIR_DEFAULT 20
#define NEXT_BLOCK  0x0022
#define COMMAND     0x0100
#define DISCARD     5
#define QUEUE       0x1000
#define DRIVER_0    0
#define PERMIT      13
#define MAP_VERSION 6
#define REPLY_MAX   260

static modbus_t *client;
static const char *board;
static int board_id;
static int board_axes;
static int tick_hz;
static char complaint[160];

__attribute__((format(printf, 1, 2))) static bool wrong(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vsnprintf(complaint, sizeof complaint, format, arguments);
    va_end(arguments);
    return false;
}

static bool same(long found, long wanted)
{
    return found == wanted || wrong("%ld, not %ld", found, wanted);
}

// True when a call of libmodbus has ended without an error.
static bool good(int result)
{
    return result >= 0 || wrong("%s", modbus_strerror(errno));
}

// The call must end with this exception.
static bool refused(int result, int code)
{
    if (result >= 0) {
        return wrong("no exception");
    }
    return errno == MODBUS_ENOBASE + code ||
           wrong("%s, not exception %02d", modbus_strerror(errno), code);
}

static int input(int address)
{
    uint16_t word = 0;

    return modbus_read_input_registers(client, address, 1, &word) == 1 ? word : -1;
}

static int holding(int address)
{
    uint16_t word = 0;

    return modbus_read_registers(client, address, 1, &word) == 1 ? word : -1;
}

static int coil(int address)
{
    uint8_t bit = 0;

    return modbus_read_bits(client, address, 1, &bit) == 1 ? bit : -1;
}

static bool write_pair(int address, uint16_t first, uint16_t second)
{
    const uint16_t words[2] = {first, second};

    return good(modbus_write_registers(client, address, 2, words));
}

static bool reset(void)
{
    return write_pair(DIR_SETUP, DIR_DEFAULT, DIR_DEFAULT);
}

// Send a request that libmodbus itself would not make. It begins with unit and function.
static int raw(uint8_t function, uint16_t first, uint16_t second, int data)
{
    uint8_t request[REPLY_MAX] = {UNIT,
                                  function,
                                  (uint8_t)(first >> 8),
                                  (uint8_t)first,
                                  (uint8_t)(second >> 8),
                                  (uint8_t)second};
    uint8_t reply[REPLY_MAX];

    if (data != 0) {
        request[6] = (uint8_t)data;
    }
    int length = data == 0 ? 6 : data + 7;
    if (modbus_send_raw_request(client, request, length > 254 ? 254 : length) < 0) {
        return -1;
    }
    int received = modbus_receive_confirmation(client, reply);
    if (received >= 3 && (reply[1] & 0x80) != 0) {
        errno = MODBUS_ENOBASE + reply[2];
        return -1;
    }
    return received;
}

static bool coils_read(void)
{
    int outputs = input(OUTPUTS);

    return same(coil(DRIVER_0), outputs & 1) && same(coil(PERMIT), outputs >> 8 & 1);
}

static bool discrete_inputs_read(void)
{
    uint8_t bits[16];
    int found = 0;

    if (!good(modbus_read_input_bits(client, 0, 16, bits))) {
        return false;
    }
    for (int i = 0; i < 16; i++) {
        found |= bits[i] << i;
    }
    return same(found, input(STATUS));
}

static bool holding_registers_read(void)
{
    static const uint16_t defaults[SETTINGS] = {1, 1152,  0, 30, 0, 1, 20,   20, 0,
                                                0, 1000,  0, 0,  2, 0, 3000, 0,  0,
                                                1, 10000, 4, 1,  1, 0, 0,    0};
    uint16_t words[SETTINGS];

    if (!good(modbus_read_registers(client, 0, SETTINGS, words))) {
        return false;
    }
    for (int i = 0; i < SETTINGS; i++) {
        if (!same(words[i], defaults[i])) {
            return false;
        }
    }
    return true;
}

static bool input_registers_read(void)
{
    uint16_t words[4];

    return good(modbus_read_input_registers(client, 0, 4, words)) &&
           same(words[0], MAP_VERSION) && same(words[2], board_id) &&
           same(words[3], board_axes);
}

static bool coil_set(int address, int on)
{
    return good(modbus_write_bit(client, address, on)) && same(coil(address), on);
}

static bool coil_written(void)
{
    return coil_set(DRIVER_0, 1) && same(input(OUTPUTS) & 1, 1) &&
           coil_set(DRIVER_0, 0) && same(input(OUTPUTS) & 1, 0);
}

static bool register_written(void)
{
    return good(modbus_write_register(client, DIR_SETUP, 33)) &&
           same(holding(DIR_SETUP), 33) && reset();
}

static bool permit_set(uint8_t on)
{
    return good(modbus_write_bits(client, PERMIT, 1, &on)) && same(coil(PERMIT), on);
}

static bool coils_written(void)
{
    return permit_set(1) && permit_set(0);
}

static bool registers_written(void)
{
    return write_pair(DIR_SETUP, 41, 42) && same(holding(DIR_SETUP), 41) &&
           same(holding(DIR_SETUP + 1), 42) && reset();
}

static bool server_id(void)
{
    uint8_t text[REPLY_MAX] = {0};
    char wanted[32];

    (void)snprintf(wanted, sizeof wanted, "pixstep %s", board);
    if (!good(modbus_report_slave_id(client, sizeof text - 1, text))) {
        return false;
    }
    if (text[0] != board_id || text[1] != 0 ||
        strncmp((const char *)&text[2], wanted, strlen(wanted)) != 0) {
        return wrong("id %u, status %u, '%s'", text[0], text[1], (const char *)&text[2]);
    }
    return true;
}

static bool mask_write(void)
{
    return good(modbus_mask_write_register(client, DIR_SETUP, 0xFFF0, 0x0005)) &&
           same(holding(DIR_SETUP), (DIR_DEFAULT & 0xFFF0) | 5) && reset();
}

static bool write_and_read(void)
{
    const uint16_t words[2] = {51, 52};
    uint16_t found[4];

    return good(modbus_write_and_read_registers(
               client, DIR_SETUP, 2, words, DIR_SETUP - 2, 4, found)) &&
           same(found[0], 0) && same(found[1], 1) && same(found[2], 51) &&
           same(found[3], 52) && reset();
}

static bool period_is(long wanted)
{
    uint16_t pair[2];

    return good(modbus_read_input_registers(client, PERIOD, 2, pair)) &&
           same((long)pair[0] << 16 | pair[1], wanted);
}

static bool pair_read(void)
{
    return period_is(tick_hz / 30);
}

static bool pair_written(void)
{
    if (!write_pair(PIXEL_HZ, 0, 50)) {
        return false;
    }
    bool followed = period_is(tick_hz / 50);

    return write_pair(PIXEL_HZ, 0, 30) && followed;
}

static bool exception_01(void)
{
    const uint8_t request[] = {UNIT, MODBUS_FC_READ_EXCEPTION_STATUS};
    uint8_t reply[REPLY_MAX];

    if (modbus_send_raw_request(client, request, sizeof request) < 0 ||
        modbus_receive_confirmation(client, reply) < 3) {
        return wrong("%s", modbus_strerror(errno));
    }
    return same(reply[1], 0x87) && same(reply[2], 1);
}

static bool exception_02(void)
{
    uint16_t words[2];

    return refused(modbus_read_registers(client, SETTINGS - 1, 2, words), 2);
}

static bool exception_03(void)
{
    return refused(modbus_write_register(client, DIR_SETUP, 0), 3) &&
           same(holding(DIR_SETUP), DIR_DEFAULT);
}

static bool exception_06(void)
{
    const uint16_t block[] = {(uint16_t)input(NEXT_BLOCK), 0, 0x21, 0, 0, 0, 1, 10};

    if (!good(modbus_write_registers(client, QUEUE, 8, block))) {
        return false;
    }
    bool busy = refused(modbus_write_register(client, DIR_SETUP, 33), 6);

    return write_pair(COMMAND, 1, DISCARD) && busy &&
           same(holding(DIR_SETUP), DIR_DEFAULT);
}

static bool broadcast(void)
{
    const uint16_t words[2] = {61, 62};

    (void)modbus_set_slave(client, MODBUS_BROADCAST_ADDRESS);
    (void)modbus_set_response_timeout(client, 0, 100000);
    int answered = modbus_write_registers(client, DIR_SETUP, 2, words);

    (void)modbus_set_slave(client, UNIT);
    (void)modbus_set_response_timeout(client, PATIENCE_S, 0);
    if (answered >= 0) {
        return wrong("answered");
    }
    return same(holding(DIR_SETUP), 61) && same(holding(DIR_SETUP + 1), 62) && reset();
}

static bool nothing_by_halves(void)
{
    const uint16_t words[2] = {71, 0};

    return refused(modbus_write_registers(client, DIR_SETUP, 2, words), 3) &&
           same(holding(DIR_SETUP), DIR_DEFAULT);
}

static bool words_125(void)
{
    uint16_t words[125];

    return same(modbus_read_input_registers(client, RECORDS, 125, words), 125);
}

static bool words_126(void)
{
    return refused(raw(MODBUS_FC_READ_HOLDING_REGISTERS, 0, 126, 0), 3);
}

static bool words_123(void)
{
    static const uint16_t words[123];

    return refused(modbus_write_registers(client, 0, 123, words), 2);
}

static bool words_124(void)
{
    return refused(raw(MODBUS_FC_WRITE_MULTIPLE_REGISTERS, 0, 124, 248), 3);
}

static bool words_121(void)
{
    static const uint16_t words[121];
    uint16_t found = 0;

    return refused(modbus_write_and_read_registers(client, 0, 121, words, 0, 1, &found),
                   2);
}

static bool bits_2000(void)
{
    static uint8_t bits[2000];

    return refused(modbus_read_bits(client, 0, 2000, bits), 2);
}

static bool bits_2001(void)
{
    return refused(raw(MODBUS_FC_READ_COILS, 0, 2001, 0), 3);
}

static bool bits_1968(void)
{
    static const uint8_t bits[1968];

    return refused(modbus_write_bits(client, 0, 1968, bits), 2);
}

static bool bits_1969(void)
{
    return refused(raw(MODBUS_FC_WRITE_MULTIPLE_COILS, 0, 1969, 247), 3);
}

static const struct {
    const char *name;
    bool (*check)(void);
} list[] = {
    {"coils read", coils_read},
    {"discrete inputs read", discrete_inputs_read},
    {"holding registers read", holding_registers_read},
    {"input registers read", input_registers_read},
    {"coil written", coil_written},
    {"register written", register_written},
    {"coils written", coils_written},
    {"registers written", registers_written},
    {"server id", server_id},
    {"mask write", mask_write},
    {"write and read", write_and_read},
    {"32-bit pair read", pair_read},
    {"32-bit pair written", pair_written},
    {"exception 01", exception_01},
    {"exception 02", exception_02},
    {"exception 03", exception_03},
    {"exception 06", exception_06},
    {"broadcast", broadcast},
    {"nothing by halves", nothing_by_halves},
    {"125 words read", words_125},
    {"126 words", words_126},
    {"123 words written", words_123},
    {"124 words", words_124},
    {"121 words in 23", words_121},
    {"2000 bits", bits_2000},
    {"2001 bits", bits_2001},
    {"1968 bits written", bits_1968},
    {"1969 bits", bits_1969},
};

static bool run_list(void)
{
    int features = input(FEATURES);

    if (features < 0) {
        (void)fprintf(stderr, "register features: %s\n", modbus_strerror(errno));
        return false;
    }
    (void)printf("features\t%d\n", features);
    for (size_t i = 0; i < sizeof list / sizeof list[0]; i++) {
        errno = 0;
        bool fine = list[i].check();
        bool served = errno != EMBXILFUN;

        const char *verdict = served ? complaint : "exception 01";

        (void)printf("%s\t%s\n", list[i].name, fine ? "ok" : verdict);
        (void)fflush(stdout);
    }
    return true;
}

int main(int argc, char **argv)
{
    if (argc != 6) {
        (void)fputs("usage: pixstep-libmodbus PORT BOARD ID AXES HZ\n", stderr);
        return 2;
    }
    board = argv[2];
    board_id = (int)strtol(argv[3], NULL, 10);
    board_axes = (int)strtol(argv[4], NULL, 10);
    tick_hz = (int)strtol(argv[5], NULL, 10);
    // A pseudo terminal has no parity.
    client = modbus_new_rtu(argv[1], 115200, 'N', 8, 1);
    if (client == NULL || modbus_set_slave(client, UNIT) != 0 ||
        modbus_connect(client) != 0) {
        (void)fprintf(stderr, "%s: %s\n", argv[1], modbus_strerror(errno));
        return 2;
    }
    (void)modbus_set_response_timeout(client, PATIENCE_S, 0);
    (void)modbus_set_byte_timeout(client, PATIENCE_S, 0);
    bool ran = run_list();
    modbus_close(client);
    modbus_free(client);
    return ran ? 0 : 2;
}
