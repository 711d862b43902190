// SPDX-License-Identifier: MIT
// Where curve_batch.S finds the members of struct walk, struct curve and struct stream; checked in
// curve_batch.c. The assembler reads this file, too: plain numbers only.
//
// Offsets and sizes in bytes.
#pragma once

// struct walk, whose first member is the curve, whose first member is its flat state.
#define CURVE_BATCH_UNTIL       39
#define CURVE_BATCH_EXACT_TICKS 43

// struct stream.
#define CURVE_BATCH_RING      0
#define CURVE_BATCH_HEAD      4
#define CURVE_BATCH_END_TICKS 13
#define CURVE_BATCH_NEXT      129 /* batch_head, with batch_tail behind it */
#define CURVE_BATCH_NOTES     2   /* the batches, from batch_head on */
#define CURVE_BATCH_NOTE      6   /* of one */
#define CURVE_BATCH_COUNT     8

// Value of the ring's high byte behind the last entry.
#define CURVE_BATCH_EMPTY 0xFF
