"""Threads that read and write one world concurrently, and torn or lost values that they observed.

    uv run --group test python benchmarks/world_threads.py [--seconds 60]

Half of the threads write: each moves three parts of its own, adds and removes parts, and all increment
one shared value. The others take snapshots and search for states that no transaction has produced.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from table import Figure, finish
from world_workload import ROOT

from skiros_py.errors import StaleVersion
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.world import World

_COUNT = "sk:missedLooks"
_SHARED = "starter_shared"
_BOXES = ("left", "right")
_KEPT = 10
_SWITCH = 1e-4
"""Interval at which threads switch [s]: a fiftieth of the default."""


@dataclass(slots=True)
class Outcome:
    """The results.

    Attributes:
        seconds: How long the threads ran [s].
        writes: Transactions that took effect.
        reads: Snapshots that were looked through.
        stale: Writes that were refused because somebody else was quicker.
        errors: Faults in threads.
        torn: States that readers saw but no transaction wrote.
        lost: Writes that the last state, the changes or the subscriber do not know of.
    """

    seconds: float = 0.0
    writes: int = 0
    reads: int = 0
    stale: int = 0
    errors: list[str] = field(default_factory=list)
    torn: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    @property
    def faults(self) -> int:
        """The number of faults."""
        return len(self.errors) + len(self.torn) + len(self.lost)


def run(seconds: float, *, threads: int = 8, opens: Callable[[Ontology], World] = World) -> Outcome:
    """Lets threads read and write one world, then searches for lost writes.

    Args:
        seconds: For how long [s].
        threads: How many; half of them write.
        opens: Makes the world, which is new.
    """
    world = opens(Ontology.load([ROOT / "ontologies"]))
    beginning = world.snapshot()
    _furnish(world, threads // 2)
    first, received = world.version, list[int]()
    world.subscribe(lambda change: received.append(change.number))
    writers = [_Writer(world, number) for number in range(threads // 2)]
    readers = [_Reader(world, len(writers)) for _ in range(threads - len(writers))]
    outcome = Outcome()
    usual = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH)
    try:
        outcome.seconds = _together([*writers, *readers], seconds, outcome.errors)
    finally:
        sys.setswitchinterval(usual)
    outcome.writes = world.version - first
    outcome.reads = sum(reader.rounds for reader in readers)
    outcome.stale = sum(writer.stale for writer in writers)
    outcome.torn = [text for reader in readers for text in reader.torn]
    outcome.lost = [*_lost(world, writers), *_not_replayed(world, beginning)]
    if received != list(range(first + 1, world.version + 1)):
        outcome.lost.append(f"the subscriber received {len(received)} of {outcome.writes} changes, or not in order")
    return outcome


class _Writer:
    """Moves its three parts together and counts their moves; counts up the shared value; adds and removes elements."""

    def __init__(self, world: World, number: int) -> None:
        self._world = world
        self._number = number
        self.rounds = 0
        self.counted = 0
        self.stale = 0
        self.added: list[str] = []

    def __call__(self) -> None:
        self.rounds += 1
        self._move()
        self._count()
        self._come_and_go()

    def _move(self) -> None:
        with self._world.transaction(f"writer {self._number}", "moves its parts") as tx:
            for part in _own(self._number):
                tx.place(part, "sk:in", _BOXES[self.rounds % 2])
                tx.set(part, _COUNT, self.rounds)

    def _count(self) -> None:
        seen = self._world.snapshot()
        number, version = seen.value(_SHARED, _COUNT), seen.stamp(_SHARED).change
        assert isinstance(number, int)
        try:
            with self._world.transaction("everybody", "counts", expects={_SHARED: version}) as tx:
                tx.set(_SHARED, _COUNT, number + 1)
        except StaleVersion:
            self.stale += 1
        else:
            self.counted += 1

    def _come_and_go(self) -> None:
        with self._world.transaction(f"writer {self._number}", "one comes, one goes") as tx:
            self.added.append(tx.add("kitting:RelayBox", placement=Placement("sk:in", _BOXES[0])))
            if len(self.added) > _KEPT:
                tx.remove(self.added[-1 - _KEPT])


class _Reader:
    """Searches for parts that were not moved together, are in two places or count backwards."""

    def __init__(self, world: World, writers: int) -> None:
        self._world = world
        self._writers = writers
        self._last = [0] * writers
        self.rounds = 0
        self.torn: list[str] = []

    def __call__(self) -> None:
        self.rounds += 1
        seen = self._world.snapshot()
        self.torn.extend(f"version {seen.version}: {text}" for text in self._faults(seen))

    def _faults(self, seen: Index) -> Iterator[str]:
        for writer in range(self._writers):
            parts = _own(writer)
            states = {(seen.placement(part), seen.value(part, _COUNT)) for part in parts}
            count = seen.value(parts[0], _COUNT)
            assert isinstance(count, int)
            if len(states) > 1:
                yield f"parts of writer {writer} apart: {states}"
            if count < self._last[writer]:
                yield f"parts of writer {writer} back at {count} after {self._last[writer]}"
            self._last[writer] = count
        left, right = (set(seen.subjects("sk:in", box)) for box in _BOXES)
        if left & right:
            yield f"in both boxes: {sorted(left & right)}"
        if left | right != set(seen.instances("sk:Manipulatable")):
            yield f"not in one of the boxes: {sorted((left | right) ^ set(seen.instances('sk:Manipulatable')))}"


def _furnish(world: World, writers: int) -> None:
    with world.transaction("benchmark", "a floor, two boxes and parts") as tx:
        tx.add("sk:Floor", id="floor")
        for box in _BOXES:
            tx.add("kitting:Box", id=box, placement=Placement("sk:on", "floor"))
        for part in (_SHARED, *(part for writer in range(writers) for part in _own(writer))):
            tx.add("kitting:Starter", None, part, {_COUNT: 0}, Placement("sk:in", _BOXES[0]))


def _own(writer: int) -> tuple[str, ...]:
    return tuple(f"starter_of_{writer}_{letter}" for letter in "abc")


def _together(jobs: list[Callable[[], None]], seconds: float, errors: list[str]) -> float:
    """Repeats each job in a thread of its own; returns the duration [s]."""
    stop = threading.Event()

    def repeat(job: Callable[[], None]) -> None:
        try:
            while not stop.is_set():
                job()
        except Exception as error:  # noqa: BLE001  any fault is what is looked for
            errors.append(repr(error))
            stop.set()

    started = time.perf_counter()
    threads = [threading.Thread(target=repeat, args=(job,)) for job in jobs]
    for thread in threads:
        thread.start()
    stop.wait(seconds)
    stop.set()
    for thread in threads:
        thread.join()
    return time.perf_counter() - started


def _lost(world: World, writers: list[_Writer]) -> Iterator[str]:
    for number, writer in enumerate(writers):
        for part in _own(number):
            if world.value(part, _COUNT) != writer.rounds:
                yield f"{part} was written {writer.rounds} times and says {world.value(part, _COUNT)}"
    counted = sum(writer.counted for writer in writers)
    if world.value(_SHARED, _COUNT) != counted:
        yield f"the shared value was counted to {counted} and says {world.value(_SHARED, _COUNT)}"
    added = [name for writer in writers for name in writer.added]
    if len(set(added)) != len(added):
        yield f"{len(added) - len(set(added))} ids were given twice"


def _not_replayed(world: World, beginning: Index) -> Iterator[str]:
    again = beginning.copy()
    for change in world.changes:
        for edit in change.edits:
            again.apply(edit)
    same = (
        sorted(again.ids()) == sorted(world.snapshot().ids())
        and list(again.statements()) == list(world.snapshot().statements())
        and all(again.element(name) == world.element(name) for name in again.ids())
    )
    if not same:
        yield "the changes, done again, lead to another state"


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="how long 8 threads read and write")
    outcome = run(parser.parse_args().seconds)
    for text in (*outcome.errors, *outcome.torn, *outcome.lost)[:20]:
        print(text)
    bad = [("errors", outcome.errors), ("torn reads", outcome.torn), ("lost writes", outcome.lost)]
    figures = [
        Figure("writes", f"{outcome.writes} ({outcome.writes / outcome.seconds:.0f} per s)"),
        Figure("snapshots looked through", f"{outcome.reads} ({outcome.reads / outcome.seconds:.0f} per s)"),
        Figure("writes refused as stale", str(outcome.stale)),
        *(Figure(what, str(len(found)), "0", not found) for what, found in bad),
    ]
    return finish("world threads", figures)


if __name__ == "__main__":
    sys.exit(main())
