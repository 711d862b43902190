// SPDX-License-Identifier: MIT
#include "law.h"

#include <math.h>
#include <stddef.h>

// Smaller coefficients bound nothing.
#define TINY 1e-12
#define FREE ((double)INFINITY)

static double least(double one, double other)
{
    return one < other ? one : other;
}

// The highest x with which bound j leaves a y that is not below 0.
static double alone(double a, double b, double most)
{
    if (a > TINY) {
        return b < 0 ? -most / b : FREE;
    }
    return fabs(b) > TINY ? most / fabs(b) : FREE;
}

// The highest x up to which y may be as low as bound i demands and as high as bound j allows.
static double together(
    const double *a, const double *b, const double *most, size_t i, size_t j)
{
    double apart = b[i] / a[i] - b[j] / a[j];

    return apart > 0 ? (most[0] / a[i] + most[1] / a[j]) / apart : FREE;
}

static double cap_of(const struct law *law,
                     const double *a,
                     const double *b,
                     const double *most)
{
    double cap = FREE;

    for (size_t i = 0; i < law->bounds; i++) {
        cap = least(cap, alone(a[i], b[i], most[i % law->motors]));
        for (size_t j = 0; a[i] > TINY && j < law->bounds; j++) {
            if (a[j] > TINY) {
                const double pair[2] = {most[i % law->motors], most[j % law->motors]};

                cap = least(cap, together(a, b, pair, i, j));
            }
        }
    }
    return cap;
}

void law_caps(const struct law *law, double *cap)
{
    for (size_t row = 0; row < law->count; row++) {
        size_t first = row * law->bounds;

        cap[row] = least(
            cap[row],
            cap_of(law, law->a + first, law->b + first, law->most + row * law->motors));
    }
}

// Lower `top`, the unknown with coefficients `of`, to what the other one's value allows.
static double bounded(const struct law *law,
                      size_t row,
                      const double *of,
                      const double *by,
                      double value,
                      double top)
{
    const double *most = law->most + row * law->motors;

    of += row * law->bounds;
    by += row * law->bounds;
    for (size_t j = 0; j < law->bounds; j++) {
        if (of[j] > TINY) {
            top = least((most[j % law->motors] + by[j] * value) / of[j], top);
        }
    }
    return top;
}

double law_backward(const struct law *law, double end, double *highest)
{
    for (size_t row = law->count; row-- > 0;) {
        double limit = least(end, law->end_cap[row]);

        end = bounded(law, row, law->b, law->a, limit, law->cap[row]);
        end = law->rest[row] != 0 ? FREE : fmax(end, 0);
        highest[row] = end;
    }
    return end;
}

double law_forward(const struct law *law,
                   const double *highest,
                   double following,
                   double w,
                   double *begin,
                   double *end)
{
    for (size_t row = 0; row < law->count; row++) {
        double limit = row + 1 < law->count ? highest[row + 1] : following;

        if (law->rest[row] != 0) {
            begin[row] = end[row] = 1;
            w = FREE;
            continue;
        }
        begin[row] = least(w, highest[row]);
        w = bounded(
            law, row, law->a, law->b, begin[row], least(limit, law->end_cap[row]));
        end[row] = w = fmax(w, 0);
    }
    return w;
}
