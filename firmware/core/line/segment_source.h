// SPDX-License-Identifier: MIT
// Where the segments of a line come from. The line decoder asks for the next segment, and it does
// not know who gives it. Today the queue of the axis gives it, to a line as well as to a seek.
//
//                       segment_source_begin()    the head: how the segments are to be read
//     segment_queue --> segment_source_next()     the next segment: pixels, dry, or over
//                       segment_source_pixels()   the quick way to it, for pixels of even steps
//                       segment_source_trip()     from now on a seek leaves out segments
//
// A source gives five things:
//
//     segment            the segment in work. The line takes its pixels one after the other, and
//                        asks for the next segment when `repeat` has become 0.
//     queue              where the quick way looks. A source that makes its segments itself gives
//                        a queue that is empty and stays so.
//     smooth, negative   how the counts of the segments are to be read
//     ends_early         whether the source may end before all that it holds is made
//     an end             the source says SEGMENTS_OVER when the line has made its last pixel. A
//                        smooth line has speed 0 then.
//
// Another kind of source, such as a jog or a braking ramp, is added in segment_source.c alone. It
// has a begin-function of its own, which sets these members, and a member that names the kind. Who
// starts such a motion begins the line with that function, as line_begin() does with
// segment_source_begin(). The quick way finds nothing in the empty queue, so the line comes to
// segment_source_next(). There the empty queue is the place where the kind is asked: it writes the
// next segment, or it says that it is over. A line whose segments are queued comes to that place
// only when its queue is dry, so the way of its pixels gets no branch more.
//
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/segment.h"       // struct segment
#include "line/segment_queue.h" // struct segment_queue

// segment_source.c writes all members but three flags. The writers of whole pixels pass pixels of
// `segment`, and the assembly among them takes segments from the queue by itself
// (even_pixels_several.S).
struct segment_source {
    // Where the segments wait; never NULL. It lasts as long as the line.
    struct segment_queue *queue;
    // The segment in work; its repeat counts the pixels that are left, 0..65535.
    struct segment segment;
    // Pixels have constant acceleration, and a count has no sign; else one speed each, and a count
    // has the sign of its direction.
    bool smooth : 1;
    // Direction of a smooth line.
    bool negative : 1;
    // The line is ahead of the pixel clock: see below.
    bool shifted : 1;
    // The line has made no piece yet: see below.
    bool fresh : 1;
    // The segments may end before they are all made: those of a seek do when its switch trips.
    bool ends_early : 1;
    // The switch of a seek has tripped; segments are left out up to one that slows down.
    bool leaving_out : 1;
    // The down mark of a seek was reached.
    bool down : 1;
    // A length of the line lacks a pixel: see below.
    bool edge_open : 1;
    // The source does not use `shifted`, `fresh` and `edge_open`: they are the line's, and line.h
    // says what they mean. They stand here because a second byte of flags would cost a byte of RAM
    // on each axis.
};

// What segment_source_next() has found.
enum segments {
    // The segment in work has pixels.
    SEGMENTS_PIXELS,
    // No segment is there, but the line has not ended. The end mark of a smooth line counts so too
    // while the speed is not 0.
    SEGMENTS_DRY,
    // The line has ended.
    SEGMENTS_OVER,
};

// Begin with the line at the front of the queue. The front must be a start mark, its parameter and
// the divider that the mark promises, all of them accepted by the check; they are removed. The
// caller has set all members of *source to 0. Returns the parameter: of its count the lowest 15
// bits (SEGMENT_PARAMETER) are the backlash, steps; its repeat is the line speed, 0..65535
// steps/pixel.
struct segment segment_source_begin(struct segment_source *source,
                                    struct segment_queue *queue);

// Take segments until one has pixels to make, or keep the one in work if it has. speed: the current
// speed of the line, 0..65535 steps/pixel (segment.h); a seek that has tripped leaves out what is
// not below it. After SEGMENTS_DRY the call may be repeated when the queue has more. After
// SEGMENTS_OVER it must not be repeated: the next entry is another line's head.
enum segments segment_source_next(struct segment_source *source, uint16_t speed);

// The quick way: put the queue's next segment in work if none is, without a call where one is. The
// repeat of the segment in work stays 0 where the queue is empty or has a mark in front; the mark
// stays there, and segment_source_next() tells what it means. Only where
// segment_source_ends_early() is false.
static inline void segment_source_pixels(struct segment_source *source)
{
    if (source->segment.repeat == 0) {
        (void)segment_queue_pop_pixels(source->queue, &source->segment);
    }
}

// One pixel of the segment in work is made. Its repeat must not be 0.
static inline void segment_source_pass_pixel(struct segment_source *source)
{
    source->segment.repeat--;
}

// Steps of a pixel of the segment in work, 0..16383, without their direction.
static inline uint16_t segment_source_steps(const struct segment_source *source)
{
    int16_t count = source->segment.count;

    return (uint16_t)(count < 0 ? -count : count);
}

// True when the segments may end before they are all made, as those of a seek do. Such a line is
// decoded only a short time ahead, and no line chains with it. The quick way must not be asked: it
// leaves nothing out.
static inline bool segment_source_ends_early(const struct segment_source *source)
{
    return source->ends_early;
}

// The switch of a seek has tripped. From the next segment_source_next() on the seek slows down:
// segments are left out up to the slowdown (segment.h), the rest of the one in work too. After the
// down mark nothing changes. Also allowed before the first segment.
void segment_source_trip(struct segment_source *source);
