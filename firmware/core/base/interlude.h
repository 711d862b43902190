// SPDX-License-Identifier: MIT
// Long work of the main loop, in pieces: checksums, replies and checks of line data. No request may
// keep a board of several axes from its rings for 4,000 cycles, so that whoever works for longer
// calls interlude() on the way. A program without axes to look after gets the empty interlude() of
// interlude.c.
//
//     request    | piece |           | piece |           | piece |
//     axes               | interlude |       | interlude |
#pragma once

// Called in the main loop, in the middle of work that may take thousands of cycles, at a place
// where nothing is half done. The image of a board looks after its axes there, if one of them moves
// (app/main.c). The caller must bear what the axes do meanwhile: a line may end, fail or be
// discarded, so that the caller reads an axis's state again afterwards.
void interlude(void);
