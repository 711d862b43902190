// SPDX-License-Identifier: MIT
// Where ledger_pixels.S finds the members of struct ledger and its records; checked in
// ledger_pixels.c. The assembler reads this file, too: plain numbers only.
//
// Offsets and sizes in bytes.
#pragma once

#if !defined(RECORDS_KEPT)
#define RECORDS_KEPT 20
#endif

// struct ledger.
#define LEDGER_PULSE     0
#define LEDGER_NEGATIVE  1
#define LEDGER_TRAIN     3
#define LEDGER_IDLE_SEEN 6
#define LEDGER_FRESH     14
#define LEDGER_LOADED    16
#define LEDGER_POSITION  20
#define LEDGER_ORIGIN    24
#define LEDGER_PIXEL     28

// struct engine_sample.
#define LEDGER_SAMPLE_TAIL 0
#define LEDGER_SAMPLE_CUT  2
#define LEDGER_SAMPLE_IDLE 4

// Periods made since the account, from which on several pixels are likely to be over.
#define LEDGER_MANY_PERIODS 48

// struct records_thinning.
#define LEDGER_THINNING_ERROR 2

// Its records, from the ledger's own beginning.
#define LEDGER_RECORDS         38
#define LEDGER_RECORDS_NEWEST  38
#define LEDGER_RECORDS_COUNT   39
#define LEDGER_RECORDS_PASSING 40
#define LEDGER_RECORDS_MADE    41
#define LEDGER_RECORDS_TO_NEXT 43
#define LEDGER_RECORDS_SHOWN   45
#define LEDGER_RECORDS_EARLY   47
#define LEDGER_RECORDS_EARLIER 8 /* RECORDS_EARLY */

// struct kept_record.
#define LEDGER_RECORD_BEYOND 4
#if FEATURE_CLOCK_STATISTICS
#define LEDGER_RECORDS_KEPT 63
#define LEDGER_RECORD_ERROR 6
#define LEDGER_RECORD_PIXEL 8
#define LEDGER_RECORD_BYTES 10
#else
#define LEDGER_RECORDS_KEPT 45
#define LEDGER_RECORD_PIXEL 6
#define LEDGER_RECORD_BYTES 8
#endif
