"""The cost of the kernel: cycles with 1,000 behaviours, successors, watched conditions, and 100 plug-ins at start-up.

    uv run --group bench python benchmarks/kernel.py

Cycles of ours, of py_trees and of a bare loop over generators are timed in turn in the same run, while the watchdog
watches ours; ratios of medians decide. For process starts, which are noisier, the best of several counts.
"""

from __future__ import annotations

import argparse
import importlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from table import Figure, finish, in_steps

from skiros_py.behaviours import Do, Parallel, Sequence
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Status
from skiros_py.execution.signals import Signals
from skiros_py.execution.watchdog import Watchdog
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.signals import Request, Signal, Value
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, REACHABLE
from skiros_py.world.vocabulary import AT
from skiros_py.world.world import World

_BEHAVIOURS = 1000
_STEPS = 100
_CONDITIONS = 100
_PLUGINS = 100
_IN_A_ROW = 50
"""Cycles of one kind that are timed before those of the next kind."""

Tick = Callable[[], object]


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20, help=f"how often {_IN_A_ROW} cycles of each kind are timed")
    parser.add_argument("--starts", type=int, default=7, help="how often a start is timed with and without plug-ins")
    options = parser.parse_args()
    figures = [*_cycles(options.rounds), _successors(), _plan_steps(), _watched(), *_start_up(options.starts)]
    return finish("kernel", figures)


# ---------------------------------------------------------------------- 1,000 behaviours


class Busy(Primitive["Busy.Params"]):
    """Runs forever."""

    name = "busy"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Takes no parameters."""

    def execute(self) -> Execution[Outcome]:
        """Yields in every cycle."""
        while True:
            yield


class Instant(Busy):
    """Ends in the tick in which it starts."""

    name = "instant"

    def execute(self) -> Execution[Outcome]:
        """Returns at once."""
        yield from ()
        return Success()


def _skill(name: str, body: Parallel | Sequence) -> Skill:
    params = (
        Param("Base", "sk:Base", "The base.", Kind.HARDWARE),
        Param("Robot", "sk:Robot", "Its robot.", Kind.PLANNING),
        Param("Place", "sk:Location", "Where it is all the time."),
    )
    post = (AT_LOCATION("Robot", "Place"),)
    description = SkillDescription(name, "For timing.", agent="Base", target="Place", params=params, post=post)
    return Skill(description, body, driver="fake")


def _arguments(world: World) -> dict[str, str]:
    return {"Base": "base_1", "Robot": "robot_1", "Place": world.objects("robot_1", AT)[0]}


def _cycles(rounds: int) -> list[Figure]:
    """Times cycles with 1,000 behaviours: a bare loop, tasks, parts of one skill, and a tree of py_trees.

    The same tasks run with 100 signal providers that nothing reads, and in every other cycle without signals and mix.
    """
    skill = _skill("crowd", Parallel(tuple(Do.of("busy") for _ in range(_BEHAVIOURS))))
    crowd = _many_tasks()
    with Bench(tiny_world(), [skill], [Busy]) as bench, Watchdog(bench.cycle):
        running = bench.managers["base_1"].start("crowd", _arguments(bench.world))
        kinds = {
            "bare": _bare_loop(),
            "tasks": crowd.step,
            "composed": bench.cycle.step,
            "peer": py_trees_tick(),
        }
        times = _in_turn({kind: tick for kind, tick in kinds.items() if tick is not None}, rounds)
        started = sum(event.module == "busy" and event.status is Status.STARTED for event in bench.events)
        if running.done or started != _BEHAVIOURS:
            raise SystemExit(f"{started} of {_BEHAVIOURS} primitives run")
    bare, composed, tasks = (times[kind] for kind in ("bare", "composed", "tasks"))
    stages = _in_turn({"with": crowd.step, "without": crowd.step_without_stages}, rounds * _IN_A_ROW, in_a_row=1)
    added = stages["with"] / stages["without"] - 1.0
    peer = times.get("peer")
    compared = f"{peer * 1e3:.2f} ms for py_trees" if peer else "py_trees is not installed: uv sync --group bench"
    ratio = peer / composed if peer else 0.0
    return [
        Figure(
            f"a cycle with {_BEHAVIOURS} primitives in one parallel", f"{composed * 1e3:.3f} ms",
            compared=compared,
        ),
        Figure(f"a cycle with {_BEHAVIOURS} tasks", f"{tasks * 1e3:.3f} ms"),
        Figure(
            f"the same as a bare loop over {_BEHAVIOURS} generators: tasks", f"{tasks / bare:.1f} x", "<= 4 x",
            tasks <= 4.0 * bare, f"{bare * 1e3:.3f} ms for the loop",
        ),
        Figure("the same: primitives in one parallel", f"{composed / bare:.1f} x", "<= 20 x", composed <= 20.0 * bare),
        Figure(
            "signals and mix that nothing uses add", f"{100.0 * added:+.1f} %", "<= 3 %",
            added <= 0.03, "100 providers, of which nothing reads; against a cycle without both stages",
        ),
        Figure("faster than py_trees", f"{ratio:.1f} x", ">= 3 x", ratio >= 3.0, "the same tree, in turn"),
    ]  # fmt: skip


class _Crowd(ControlCycle):
    def step_without_stages(self) -> None:
        """One cycle without signals and mix."""
        self._obey_halt()
        self._do(self._exchanging, self.board.exchange)
        self._settle()
        self._tick_all()
        self._obey_halt()
        self._sort_out()
        for observer in tuple(self._observers):
            if not observer.done:
                self._observe(observer)
        self._keep_pace()


class _Unread:
    """A signal provider that nothing reads."""

    every_cycle = False
    requests: tuple[Request, ...] = ()

    def __init__(self, number: int) -> None:
        self.name = f"unread {number}"
        self.provides: tuple[Signal, ...] = (Signal(f"unread_{number}"),)

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:  # noqa: ARG002 - the protocol
        raise AssertionError(f"{self.name} was computed, and nothing reads it")


def _bare_loop() -> Tick:
    generators = [_for_ever() for _ in range(_BEHAVIOURS)]

    def tick() -> None:
        for generator in generators:
            next(generator)

    return tick


def _many_tasks() -> _Crowd:
    cycle = _Crowd(DeviceBoard(FakeCell(read_cell(tiny_world(), ["robot_1"]))))
    cycle.signals = Signals(cycle.board, [_Unread(number) for number in range(100)])
    for _ in range(_BEHAVIOURS):
        cycle.start(_for_ever(), "busy")
    return cycle


def _for_ever() -> Execution[None]:
    while True:
        yield


def py_trees_tick() -> Tick | None:
    """Returns a tick of py_trees' tree, a parallel of running behaviours; None if py_trees is missing."""
    try:
        py_trees: Any = importlib.import_module("py_trees")
    except ImportError:
        return None
    policy = py_trees.common.ParallelPolicy.SuccessOnAll(synchronise=False)
    root = py_trees.composites.Parallel("crowd", policy=policy)
    root.add_children([py_trees.behaviours.Running(name=f"busy {n}") for n in range(_BEHAVIOURS)])
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup()
    tick: Tick = tree.tick
    tick()
    if root.status != py_trees.common.Status.RUNNING:
        raise SystemExit(f"the peer's tree does not run: {root.status}")
    return tick


def _in_turn(kinds: dict[str, Tick], rounds: int, in_a_row: int = _IN_A_ROW) -> dict[str, float]:
    """Returns the median time of one tick of each kind [s]."""
    for tick in kinds.values():
        tick()
        tick()
    times: dict[str, list[float]] = {kind: [] for kind in kinds}
    for _ in range(rounds):
        for kind, tick in kinds.items():
            times[kind] += [_timed(tick) for _ in range(in_a_row)]
    return {kind: statistics.median(found) for kind, found in times.items()}


def _timed(tick: Tick) -> float:
    started = time.perf_counter()
    tick()
    return time.perf_counter() - started


# ---------------------------------------------------------------------- successors and conditions


def _successors() -> Figure:
    """Counts the cycles of a sequence of steps of one tick each; more than one cycle per step would be idle."""
    skill = _skill("steps", Sequence(tuple(Do.of("instant") for _ in range(_STEPS))))
    with Bench(tiny_world(), [skill], [Instant]) as bench:
        before = bench.cycle.board.snapshot.cycle
        running = bench.managers["base_1"].start("steps", _arguments(bench.world))
        while not running.done:
            bench.cycle.step()
        used = bench.cycle.board.snapshot.cycle - before
    if not isinstance(running.result, Success):
        raise SystemExit(f"the sequence failed: {running.result}")
    what = f"idle cycles between {_STEPS} steps of one tick each"
    return Figure(what, str(used - _STEPS), "= 0", used == _STEPS, f"{used} cycles in all")


def _plan_steps() -> Figure:
    """Counts the cycles between the end of one step of a plan and the start of the next."""
    with Bench(tiny_world()) as bench:
        report = bench.pursue("In(ball_1, slot_1)")
        period = bench.cycle.board.period
        at = [(event.status, round(event.time / period)) for event in bench.events if event.kind == "skill"]
    if not report.reached:
        raise SystemExit(f"the goal was not reached: {report}")
    ends = [cycle for status, cycle in at if status is Status.TERMINATED]
    starts = [cycle for status, cycle in at if status is Status.STARTED]
    idle = sum(start - end - 1 for end, start in zip(ends, starts[1:], strict=False))
    return Figure(f"idle cycles between the {len(starts)} steps of a plan", str(idle), "= 0", idle == 0)


def _watched() -> Figure:
    """Times one cycle's check of conditions whose values have not changed."""
    world = tiny_world()
    conditions = [REACHABLE(element) for element in sorted(world.instances("sk:Location"))]
    watched = [conditions[n % len(conditions)] for n in range(_CONDITIONS)]
    watches = Watches(world)
    asked = [watches.add([condition]) for condition in watched]
    kinds: dict[str, Tick] = {
        "watched": lambda: [watch.broken() for watch in asked],
        "evaluated": lambda: [condition.evaluate(world, {}) for condition in watched],
    }
    times = _in_turn(kinds, rounds=10)
    taken = times["watched"]
    compared = f"{times['evaluated'] * 1e6:.0f} µs for evaluating them"
    return in_steps(f"{_CONDITIONS} watched conditions, nothing changed: a cycle", taken, 280, compared)


# ---------------------------------------------------------------------- plug-ins

_MODULE = '''
from dataclasses import dataclass
from skiros_py.behaviours import Do, P
from skiros_py.skills.outcome import Success
from skiros_py.skills.conditions import ConditionType, Related, Role
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription

class Beep(Primitive["Beep.Params"]):
    """Beeps."""
    name = "beep_{n}"
    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base that beeps.", kind=Kind.HARDWARE)
    def execute(self):
        yield
        return Success()

THERE = ConditionType(
    "There{n}", (Role("robot", "sk:Robot"), Role("place", "sk:Location")), Related("sk:at", "robot", "place"), "There."
)
GREET = Skill(
    SkillDescription(
        name="greet_{n}", help="Beeps.", agent="Base", target="Place",
        params=(
            Param("Base", "sk:Base", "The base.", Kind.HARDWARE),
            Param("Robot", "sk:Robot", "Its robot.", Kind.PLANNING),
            Param("Place", "sk:Location", "Where."),
        ),
        post=(THERE("Robot", "Place"),),
    ),
    Do.of("beep_{n}", base=P("Base")), driver="fake",
)
'''
_ENTRY_POINTS = """[skiros.skills]
greet_{n} = bench_plugin_{n}:GREET

[skiros.primitives]
beep_{n} = bench_plugin_{n}:Beep
"""
_START = """
import sys
from skiros_py.station.session import Options, Session
with Session("kitting", Options(fake=True)) as session:
    found = sum(name.startswith("greet_") for name in session.catalogue.skills)
    if found != int(sys.argv[1]):
        sys.exit(f"{found} of {sys.argv[1]} plug-ins loaded")
"""


def _start_up(starts: int) -> Iterator[Figure]:
    """Times opening a session on the fake robot, with and without 100 more distributions."""
    with tempfile.TemporaryDirectory() as folder:
        for n in range(_PLUGINS):
            _write_plugin(Path(folder), n)
        environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}  # as users start it: compiled once
        environments = {"without": environment, "with": {**environment, "PYTHONPATH": folder}}
        times: dict[str, list[float]] = {kind: [] for kind in environments}
        for _ in range(starts + 1):
            for kind, environment in environments.items():
                times[kind].append(_start(environment, _PLUGINS if kind == "with" else 0))
    del times["with"][0], times["without"][0]  # bytecode and file cache
    alone, added = min(times["without"]), min(times["with"]) - min(times["without"])
    yield Figure("start of a session on the fake robot, best", f"{alone:.2f} s")
    yield in_steps(f"{_PLUGINS} plug-ins add, of the best", added, 1.7e6)


def _write_plugin(folder: Path, n: int) -> None:
    (folder / f"bench_plugin_{n}.py").write_text(_MODULE.replace("{n}", str(n)), encoding="utf-8")
    info = folder / f"bench_plugin_{n}-1.0.dist-info"
    info.mkdir()
    metadata = f"Metadata-Version: 2.1\nName: bench-plugin-{n}\nVersion: 1.0\n"
    (info / "METADATA").write_text(metadata, encoding="utf-8")
    (info / "entry_points.txt").write_text(_ENTRY_POINTS.replace("{n}", str(n)), encoding="utf-8")


def _start(environment: dict[str, str], plugins: int) -> float:
    """Starts a process that opens and closes a session with so many plug-ins more; returns its wall time [s]."""
    command = [sys.executable, "-c", _START, str(plugins)]
    started = time.perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    taken = time.perf_counter() - started
    if done.returncode != 0:
        raise SystemExit(f"a session did not start:\n{done.stderr}")
    return taken


if __name__ == "__main__":
    sys.exit(main())
