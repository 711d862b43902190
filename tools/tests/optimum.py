# SPDX-License-Identifier: MIT
"""The least time for a path within limits, by linear programming: independent of the planner.

The unknowns are w = (du/dt)^2 on a grid of its own, finer than the planner's. Constraints are taken
in the middle of each piece; the time of a piece, 2h/(sqrt(x) + sqrt(y)), is convex, so planes that
touch it from below make a linear program whose result is never above the optimum of this grid.
"""

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

# Nodes for an interval of the planner's: a straight one has ramps at its ends, however long it is.
_EVEN = np.linspace(0, 1, 5)
_CLOSER = (1 - np.cos(np.linspace(0, np.pi, 97))) / 2
_LEVELS = (1.0, 1e-1, 1e-2, 1e-3)
_LEAST = 1e-9
_ROUNDS = 12


def least_ms(path, acceleration, speed):
    """Return a lower bound of the time and the time of a plan that is within the limits."""
    h, first, second = _sampled(path)
    count = len(h)
    rows = _constraints(h, first, second, acceleration, speed)
    cuts = [_planes(h, np.full(count + 1, level)) for level in _LEVELS]
    best = np.inf
    cost = np.concatenate([np.zeros(count + 1), np.ones(count)])
    bounds = [(0, 1)] * (count + 1) + [(0, None)] * count
    low = 0.0
    for _ in range(_ROUNDS):
        matrix = sparse.vstack([rows[0], *(cut[0] for cut in cuts)], format="csr")
        limit = np.concatenate([rows[1], *(cut[1] for cut in cuts)])
        found = linprog(cost, A_ub=matrix, b_ub=limit, bounds=bounds, method="highs")
        assert found.status == 0, found.message
        low = found.fun
        w = np.maximum(found.x[: count + 1], _LEAST)
        best = min(best, float(np.sum(2 * h / (np.sqrt(w[:-1]) + np.sqrt(w[1:])))))
        if best <= low * 1.002:
            break
        cuts.append(_planes(h, w))
    return low, best


def _sampled(path):
    """Return step, first and second derivative in the middle of each piece of the finer grid."""
    nodes = [_CLOSER if straight else _EVEN for straight in path.straight]
    index = np.repeat(np.arange(len(path)), [len(one) - 1 for one in nodes])
    h = np.concatenate([np.diff(one) for one in nodes]) * path.du[index]
    middle = np.concatenate([(one[1:] + one[:-1]) / 2 for one in nodes])
    s = (middle * path.du[index])[:, None]
    first = path.speed[index] + path.bend[index] * s + path.twist[index] * s**2 / 2
    return h, first, path.bend[index] + path.twist[index] * s


def _constraints(h, first, second, acceleration, speed):
    count, motors = first.shape
    blocks, limits = [], []
    left, right = np.arange(count), np.arange(1, count + 1)
    for motor in range(motors):
        a = first[:, motor] / (2 * h) + second[:, motor] / 2  # of y
        b = -first[:, motor] / (2 * h) + second[:, motor] / 2  # of x
        v = first[:, motor] ** 2 / 2
        for x, y, most in (
            (b, a, acceleration[motor]),
            (-b, -a, acceleration[motor]),
            (v, v, speed[motor] ** 2),
        ):
            data = np.concatenate([x, y])
            place = (np.tile(np.arange(count), 2), np.concatenate([left, right]))
            blocks.append(sparse.csr_matrix((data, place), shape=(count, 2 * count + 1)))
            limits.append(np.full(count, most))
    return sparse.vstack(blocks, format="csr"), np.concatenate(limits)


def _planes(h, w):
    """Return rows for t >= f(w) + f'(w) (x - w), the plane that touches the time from below."""
    count = len(h)
    x, y = np.sqrt(w[:-1]), np.sqrt(w[1:])
    value = 2 * h / (x + y)
    slope_x, slope_y = -h / (x * (x + y) ** 2), -h / (y * (x + y) ** 2)
    data = np.concatenate([slope_x, slope_y, -np.ones(count)])
    rows = np.tile(np.arange(count), 3)
    columns = np.concatenate(
        [np.arange(count), np.arange(1, count + 1), count + 1 + np.arange(count)]
    )
    matrix = sparse.csr_matrix((data, (rows, columns)), shape=(count, 2 * count + 1))
    return matrix, slope_x * w[:-1] + slope_y * w[1:] - value
