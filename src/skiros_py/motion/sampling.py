"""Sampling planners in Python: RRT-Connect, a lazy probabilistic roadmap, and expansive-spaces trees.

They are each a :class:`~skiros_py.ports.motion.SamplingPlanner`, bounded by samples and not by time.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from skiros_py.geometry import Array
from skiros_py.ports.motion import SearchTask

_LOCAL = 0.5  # share of samples drawn around the straight line
_SPREAD = 0.6  # [rad] standard deviation of those
_BRANCH = 0.35  # [rad] length of one branch of a tree
_BOXED_IN = 600  # samples after which a search ends one of whose trees has not got beyond its root
_NEARER = 0.05  # [rad] by which a branch must come nearer to what it grows towards; constraints may throw it back
_CROWD = 0.5  # [rad] within which nodes of an expansive tree crowd each other
_EXPANSION = 0.8  # [rad] greatest step of each joint from a node of such a tree
_LINK = 2.5  # [rad] distance over which two such trees are linked
_BATCH = 200  # samples added to a roadmap at a time
_NEIGHBOURS = 12  # with which a sample of a roadmap is linked


class RrtConnect:
    """RRT-Connect of Kuffner and LaValle (ICRA 2000)."""

    name = "rrt-connect"

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Returns way points from start to goal, or None."""
        rng = np.random.default_rng(task.seed)
        here, there = _Tree(task.start), _Tree(task.goal)
        for number in range(task.iterations):
            boxed_in = number == _BOXED_IN and 1 in (len(here.postures), len(there.postures))
            if boxed_in and not task.constrained:  # constraints throw most branches back, boxed in or not
                return None
            leaf = self._extend(task, here, _sample(task, rng))
            if leaf is not None:
                other = self._reach(task, there, here.postures[leaf])
                if other is not None:
                    return _joined(task, here.path(leaf), there.path(other))
            here, there = there, here
        return None

    def _extend(self, task: SearchTask, tree: _Tree, target: Array) -> int | None:
        nearest = tree.nearest(target)
        origin = tree.postures[nearest]
        way = float(np.linalg.norm(target - origin))
        if way < 1e-9:
            return nearest
        posture = task.project(target if way <= _BRANCH else origin + (_BRANCH / way) * (target - origin))
        if posture is None or float(np.linalg.norm(target - posture)) > max(0.0, way - _NEARER):
            return None
        return tree.add(posture, nearest) if task.straight(origin, posture) else None

    def _reach(self, task: SearchTask, tree: _Tree, target: Array) -> int | None:
        leaf = self._extend(task, tree, target)
        while leaf is not None and not np.array_equal(tree.postures[leaf], target):
            leaf = self._extend(task, tree, target)
        return leaf


class Est:
    """Expansive-spaces trees of Hsu, Latombe and Motwani (ICRA 1997), one from each end."""

    name = "est"

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Returns way points from start to goal, or None."""
        rng = np.random.default_rng(task.seed)
        here, there = _Tree(task.start), _Tree(task.goal)
        for _ in range(task.iterations):
            leaf = self._expand(task, here, rng)
            if leaf is not None:
                posture = here.postures[leaf]
                other = there.nearest(posture)
                near = there.postures[other]
                if float(np.linalg.norm(near - posture)) <= _LINK and task.straight(posture, near):
                    return _joined(task, here.path(leaf), there.path(other))
            here, there = there, here
        return None

    def _expand(self, task: SearchTask, tree: _Tree, rng: np.random.Generator) -> int | None:
        """Grows a tree from a node that few others crowd."""
        sums = np.cumsum(1.0 / tree.crowds)
        node = int(np.searchsorted(sums[:-1], rng.random() * sums[-1]))
        origin = tree.postures[node]
        posture = task.project(
            np.clip(origin + rng.uniform(-_EXPANSION, _EXPANSION, len(origin)), task.lower, task.upper)
        )
        return tree.add(posture, node) if posture is not None and task.straight(origin, posture) else None


class Prm:
    """A probabilistic roadmap whose edges are checked when a path leads over them (Bohlin and Kavraki, ICRA 2000)."""

    name = "prm"

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Returns way points from start to goal, or None."""
        rng = np.random.default_rng(task.seed)
        nodes, known = [task.start, task.goal], dict[tuple[int, int], bool]()
        for _ in range(max(1, task.iterations // _BATCH)):
            samples = (task.project(_sample(task, rng)) for _ in range(_BATCH))
            nodes += [sample for sample in samples if sample is not None and task.clear(sample)]
            path = self._path(task, np.array(nodes), known)
            if path is not None:
                return path
        return None

    def _path(self, task: SearchTask, nodes: Array, known: dict[tuple[int, int], bool]) -> list[Array] | None:
        """Returns the shortest path of the roadmap whose edges are all clear; what is checked is known from then on."""
        ways, others = map(np.asarray, KDTree(nodes).query(nodes, k=min(len(nodes), _NEIGHBOURS + 1)))
        edges = {
            (min(i, int(j)), max(i, int(j))): float(way)
            for i in range(len(nodes))
            for j, way in zip(others[i], ways[i], strict=True)
            if i != j
        }
        edges = {edge: way for edge, way in edges.items() if known.get(edge, True)}
        while True:
            first, second = np.array(list(edges) or [(0, 0)]).T
            graph = csr_array((list(edges.values()) or [0.0], (first, second)), shape=(len(nodes), len(nodes)))
            away, before = dijkstra(graph, directed=False, indices=[0], return_predecessors=True)
            if not np.isfinite(away[0, 1]):
                return None
            path = [1]
            while path[-1] != 0:
                path.append(int(before[0, path[-1]]))
            for a, b in pairwise(reversed(path)):
                edge = min(a, b), max(a, b)
                if edge not in known:
                    known[edge] = task.straight(nodes[a], nodes[b])
                if not known[edge]:
                    del edges[edge]
                    break
            else:
                return [nodes[node] for node in reversed(path)]


class _Tree:
    """Postures that are each reached from their parent; the first one is the root."""

    def __init__(self, root: Array) -> None:
        self.postures: list[Array] = [root]
        self._parents: list[int] = [-1]
        self._stack = np.empty((256, len(root)))
        self._stack[0] = root
        self._crowds = np.ones(256)

    @property
    def crowds(self) -> Array:
        """How many postures are near each, itself included."""
        return self._crowds[: len(self.postures)]

    def add(self, posture: Array, parent: int) -> int:
        count = len(self.postures)
        if count == len(self._stack):
            self._stack = np.vstack([self._stack, np.empty_like(self._stack)])
            self._crowds = np.concatenate([self._crowds, np.ones(count)])
        near = np.abs(self._stack[:count] - posture).max(axis=1) < _CROWD
        self._crowds[:count] += near
        self._crowds[count] = 1 + near.sum()
        self._stack[count] = posture
        self.postures.append(posture)
        self._parents.append(parent)
        return count

    def nearest(self, target: Array) -> int:
        known = self._stack[: len(self.postures)]
        return int(np.argmin(((known - target) ** 2).sum(axis=1)))

    def path(self, leaf: int) -> list[Array]:
        """Returns the way from a leaf back to the root."""
        way = []
        while leaf >= 0:
            way.append(self.postures[leaf])
            leaf = self._parents[leaf]
        return way


def _sample(task: SearchTask, rng: np.random.Generator) -> Array:
    if rng.random() >= _LOCAL:
        return rng.uniform(task.lower, task.upper)
    middle = task.start + rng.random() * (task.goal - task.start)
    return np.clip(middle + rng.normal(0.0, _SPREAD, len(middle)), task.lower, task.upper)


def _joined(task: SearchTask, one: list[Array], other: list[Array]) -> list[Array]:
    """Joins the ways from two leaves that meet back to their roots into one from the start to the goal."""
    path = [*one[::-1], *(other[1:] if np.array_equal(one[0], other[0]) else other)]
    return path if np.array_equal(path[0], task.start) else path[::-1]
