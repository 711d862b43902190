// SPDX-License-Identifier: MIT
// Long work of the main loop, in pieces: checksums, replies and checks of line data. No request may
// keep a board of several axes from its rings for 4,000 cycles.
//
//     request    | piece |           | piece |           | piece |
//     axes               | interlude |       | interlude |
#pragma once

// Called in the middle of work that may take thousands of cycles, where nothing is half done. The
// image looks after its axes there, if one of them moves (app/main.c); elsewhere nothing happens.
// What the axes do meanwhile the caller must bear: a line may end, fail or be discarded.
void interlude(void);
