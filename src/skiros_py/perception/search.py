"""Compass search of several starts at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skiros_py.perception.heightmaps import Floats

_COMPASS = np.vstack([np.eye(3), -np.eye(3)]).astype(np.float32)


def compass_search(
    cost: Callable[[Floats], Floats], starts: Floats, *, step: tuple[float, float], halvings: int, rounds: int
) -> tuple[Floats, Floats]:
    """Walks every start downhill in x, y and yaw, halving its steps where no neighbour is better.

    Args:
        cost: Costs of poses (x, y, yaw) of shape (m, 3).
        starts: Poses (x, y, yaw) [m, rad], shape (n, 3).
        step: First step in x and y [m], and in yaw [rad].
        halvings: How often the steps may be halved.
        rounds: Greatest number of steps tried for each start.

    Returns:
        The poses reached and their costs.
    """
    poses, costs = starts.astype(np.float32), cost(starts)
    unit = np.array([step[0], step[0], step[1]], dtype=np.float32)
    level = np.zeros(len(poses), dtype=np.int64)
    for _ in range(rounds):
        active = np.flatnonzero(level <= halvings)
        if len(active) == 0:
            break
        scale = (0.5 ** level[active]).astype(np.float32)
        neighbours = poses[active, None, :] + scale[:, None, None] * (_COMPASS * unit)[None]
        tried = cost(neighbours.reshape(-1, 3)).reshape(len(active), len(_COMPASS))
        best = tried.argmin(axis=1)
        better = tried[np.arange(len(active)), best] < costs[active]
        poses[active[better]] = neighbours[better, best[better]]
        costs[active[better]] = tried[better, best[better]]
        level[active[~better]] += 1
    return poses, costs
