"""Devices belong to one module at a time, and come free at every end of it, when they stand."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from skiros_py.behaviours import Do, Fallback, P, Parallel, Policy, Timeout
from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import UsageError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.running import RunningModule
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.outcome import Failure, Outcome, Success, tick
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend

SPEED = 0.5
BRAKING = 0.1


class Sluggish(FakeCell):
    """Its bases take a while to brake."""

    stops = False

    @property
    def braking_time(self) -> float:
        return 2.0 * BRAKING

    def halt(self) -> None:
        self.stops = True

    def release(self) -> None:
        self.stops = False

    def exchange(self, commands: Commands) -> Snapshot:
        heard = {} if self.stops else commands
        coasting = {
            base: BaseTwist(max(0.0, state.linear - SPEED * self.period / BRAKING), 0.0)
            for base, state in self.read().of(BaseState).items()
        }
        return super().exchange({**coasting, **heard})


class Use(Primitive["Use.Params"]):
    """Drives a base and holds an arm for some cycles, and ends as told."""

    name: ClassVar[str] = "use"
    holders: ClassVar[dict[str, object]] = {}

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        cycles: int = param("integer", "How many cycles.", kind=Kind.OFFLINE, default=10)
        ends: str = param("text", "How.", kind=Kind.OFFLINE, default="well")

    def execute(self) -> Execution[Outcome]:
        base = Base(self.context.board, self.params.base)
        assert base.state.still, "it was handed over while it moved"
        devices = [value for key in ("base", "arm") if (value := getattr(self.params, key, None))]
        assert not [d for d in devices if self.holders.get(d)], "somebody else has it"
        self.holders.update(dict.fromkeys(devices, self))
        try:
            for _ in range(self.params.cycles):
                assert all(self.holders[d] is self for d in devices)
                base.command(BaseTwist(SPEED, 0.0))
                yield
            if self.params.ends == "raises":
                raise ValueError("no such gear")
            while not base.state.still:
                yield
        finally:
            # A run of an earlier test, which the garbage collector ends now, leaves the holders alone.
            self.holders.update({d: None for d in devices if self.holders.get(d) is self})
        return Success() if self.params.ends == "well" else Failure(self.params.ends)


class Drive(Use):
    """The same with a base only."""

    name: ClassVar[str] = "roll"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        cycles: int = param("integer", "How many cycles.", kind=Kind.OFFLINE, default=10)
        ends: str = param("text", "How.", kind=Kind.OFFLINE, default="well")


class Race(Use):
    """Calls twice for one base and drops the first of them when it has begun; the second waits for what that had."""

    name: ClassVar[str] = "race"

    def execute(self) -> Execution[Outcome]:
        called = {"base": self.params.base, "cycles": self.params.cycles}
        dropped, kept = self.call("roll", **called), self.call("roll", ends=self.params.ends, **called)
        for _ in range(2):
            for call in (dropped, kept):
                if (outcome := tick(call)) is not None:
                    return outcome
            yield
        dropped.close()
        return (yield from kept)


ARM = Param("Arm", "sk:Arm", "The arm.", Kind.HARDWARE)
CYCLES = Param("Cycles", "integer", "How many.", Kind.OFFLINE, 10)
SHIFT = replace(
    DRIVE, name="shift", params=(*DRIVE.params, ARM, CYCLES), pre=(), post=(~AT_LOCATION("Robot", "Location"),)
)
BODY = Fallback.of(
    Timeout(Do.of("use", base=P("Base"), arm=P("Arm"), cycles=P("Cycles")), 0.06),
    Parallel.of(
        Do.of("roll", base=P("Base"), cycles=P("Cycles"), ends="slipped"),
        Do.of("use", base=P("Base"), arm=P("Arm"), cycles=3),
        policy=Policy.FIRST_SUCCESS,
    ),
)
SHIFTING = Skill(SHIFT, BODY, finish=Do.of("roll", base=P("Base"), cycles=2), driver="fake")
PLACE = {"Location": "box_a"}
BOTH = {"base": "base_1", "arm": "arm_1"}


@pytest.fixture(autouse=True)
def _fresh() -> None:
    Use.holders.clear()


def bench_of(robots: int = 1) -> Bench:
    return Bench(tiny_world(robots=robots), (SHIFTING,), (Use, Drive, Race), cell=Sluggish)


def free(bench: Bench, *devices: str) -> bool:
    with bench.managers.claims.request("the test", devices) as claim:
        return claim.granted


# ------------------------------------------------------------------ one after the other


def test_of_two_runs_that_need_one_device_the_later_waits_and_then_runs() -> None:
    with bench_of() as bench:
        first = bench.managers["base_1"].start("roll", {"cycles": 20})
        second = bench.managers["arm_1"].start("use", BOTH)
        bench.advance(0.05)
        assert [e.module for e in bench.events if e.status is Status.STARTED] == ["roll"]

        bench.until(lambda: first.done)
        assert not second.done
        bench.until(lambda: second.done)
        assert first.result == second.result == Success()


def test_a_skill_that_waits_for_a_device_names_the_run_that_holds_it() -> None:
    with bench_of() as bench:
        bench.managers["arm_1"].start("use", BOTH)
        bench.managers["base_1"].start("shift", PLACE)
        bench.advance(0.02)

        assert "waits for arm_1 (use), base_1 (use)" in [e.text for e in bench.events]


def _raises(bench: Bench, running: RunningModule) -> None:
    bench.until(lambda: running.done)


def _loses(bench: Bench, running: RunningModule) -> None:
    bench.managers["arm_1"].lose("its host is gone")
    running.stop()


def _stops_all(bench: Bench, running: RunningModule) -> None:
    bench.cycle.stop_all()
    bench.cycle.reset()


@pytest.mark.parametrize(
    ("more", "end"),
    [
        ({"cycles": 5}, _raises),
        ({"cycles": 5, "ends": "slipped"}, _raises),
        ({"cycles": 5, "ends": "raises"}, _raises),
        ({"cycles": 999}, lambda _, running: running.stop()),
        ({"cycles": 999}, lambda _, running: running.cancel("the plan changed")),
        ({"cycles": 999}, lambda bench, _: bench.managers.close("arm_1")),
        ({"cycles": 999}, _loses),
        ({"cycles": 999}, _stops_all),
    ],
    ids=["success", "failure", "raise", "stop", "break off", "close", "lost", "stop all"],
)
def test_the_devices_of_a_run_are_released_after_any_end_once_they_stand_still(
    more: dict[str, Any], end: Callable[[Bench, RunningModule], None]
) -> None:
    with bench_of() as bench:
        running = bench.managers["arm_1"].start("use", {**BOTH, **more})
        bench.advance(0.02)
        assert not free(bench, "base_1")
        assert not free(bench, "arm_1")
        end(bench, running)

        bench.until(lambda: free(bench, "base_1", "arm_1"), limit=BRAKING + 0.1)
        assert bench.cycle.board.still
        assert bench.managers["base_1"].start("roll", {}) is not None
        bench.advance(1.0)
        assert bench.events[-1].status is Status.TERMINATED


@pytest.mark.parametrize("cycles", [3, 999])
def test_a_skill_passes_a_device_to_the_next_part_only_once_it_stands_still(cycles: int) -> None:
    with bench_of() as bench:
        outcome = bench.run("shift", Cycles=cycles, **PLACE)

        assert isinstance(outcome, Success), outcome
        assert free(bench, "base_1", "arm_1")


def test_a_stopped_waiting_run_does_not_block_others() -> None:
    with bench_of() as bench:
        first = bench.managers["base_1"].start("roll", {"cycles": 40})
        waiting = bench.managers["arm_1"].start("use", BOTH)
        bench.advance(0.02)
        waiting.stop()
        bench.advance(0.02)

        assert waiting.result == Failure("use was stopped")
        assert [e.status for e in bench.events if e.module == "use"] == [Status.PREEMPTED]
        assert free(bench, "arm_1")
        bench.until(lambda: first.done)
        assert first.result == Success()


# ------------------------------------------------------------------ any order of everything

_LETTER = {Status.STARTED: "s", Status.RUNNING: "r", Status.TERMINATED: "e", Status.ERROR: "e", Status.PREEMPTED: "p"}
_ENDED = re.compile(r"(sr*[ep]|p)*")
_STORY = re.compile(r"(sr*[ep]|p)*(sr*)?")
"""Started, progress, one end; what was stopped before it began has but the end."""
_AGENTS = ("base_1", "arm_1", "base_2", "arm_2")
_ENDINGS = st.sampled_from(["well", "slipped", "raises"])


class Modules(RuleBasedStateMachine):
    """Modules of four managers on the devices of two robots, started, stopped, paused and cancelled in any order."""

    def __init__(self) -> None:
        super().__init__()
        Use.holders.clear()
        self.bench = bench_of(robots=2)
        self.runs: list[RunningModule] = []

    @property
    def live(self) -> list[RunningModule]:
        return [run for run in self.runs if not run.done]

    def start(self, agent: str, module: str, arguments: dict[str, Any]) -> None:
        manager = self.bench.managers[agent]
        if module in manager.running:
            with pytest.raises(UsageError, match="is running already"):
                manager.start(module, arguments)
        else:
            self.runs.append(manager.start(module, arguments))

    @rule(
        agent=st.sampled_from(_AGENTS),
        base=st.sampled_from([1, 2]),
        arm=st.sampled_from([1, 2]),
        cycles=st.sampled_from([0, 1, 7, 9999]),
        ends=_ENDINGS,
    )
    def start_use(self, agent: str, base: int, arm: int, cycles: int, ends: str) -> None:
        self.start(agent, "use", {"base": f"base_{base}", "arm": f"arm_{arm}", "cycles": cycles, "ends": ends})

    @rule(agent=st.sampled_from(_AGENTS), robot=st.sampled_from([1, 2]), cycles=st.sampled_from([0, 7]), ends=_ENDINGS)
    def start_race(self, agent: str, robot: int, cycles: int, ends: str) -> None:
        self.start(agent, "race", {"base": f"base_{robot}", "arm": f"arm_{robot}", "cycles": cycles, "ends": ends})

    @rule(agent=st.sampled_from(_AGENTS), base=st.sampled_from([1, 2]), cycles=st.sampled_from([0, 7]), ends=_ENDINGS)
    def start_roll(self, agent: str, base: int, cycles: int, ends: str) -> None:
        self.start(agent, "roll", {"base": f"base_{base}", "cycles": cycles, "ends": ends})

    @rule(number=st.sampled_from([1, 2]), arm=st.sampled_from([1, 2]), cycles=st.sampled_from([0, 5, 60]))
    def start_skill(self, number: int, arm: int, cycles: int) -> None:
        self.start(f"base_{number}", "shift", {**PLACE, "Arm": f"arm_{arm}", "Cycles": cycles})

    @precondition(lambda self: self.live)
    @rule(data=st.data(), action=st.sampled_from(["stop", "pause", "resume", "step", "cancel"]))
    def disturb(self, data: st.DataObject, action: str) -> None:
        run = data.draw(st.sampled_from(self.live))
        arguments = ("the plan changed",) if action == "cancel" else ()
        getattr(run, action)(*arguments)

    @rule(cycles=st.sampled_from([1, 1, 2, 30]))
    def advance(self, cycles: int) -> None:
        for _ in range(cycles):
            self.bench.cycle.step()

    @invariant()
    def nobody_broke_but_who_was_told_to(self) -> None:
        assert [event.text for event in self.bench.events if "AssertionError" in event.text] == []

    @invariant()
    def every_story_is_sound(self) -> None:
        assert [story for story in _stories(self.bench.events).items() if not _STORY.fullmatch(story[1])] == []

    def teardown(self) -> None:
        for run in self.live:
            run.resume()
        for run in self.live:
            if run.arguments.get("cycles") == 9999:
                run.stop()
        self.bench.until(lambda: not self.live, limit=30.0)
        self.bench.advance(0.02)
        assert free(self.bench, "base_1", "base_2", "arm_1", "arm_2")
        assert self.bench.cycle.board.still
        assert [story for story in _stories(self.bench.events).items() if not _ENDED.fullmatch(story[1])] == []
        self.bench.close()


def _stories(events: list[ModuleEvent]) -> Mapping[tuple[str, str, str], str]:
    stories: dict[tuple[str, str, str], str] = defaultdict(str)
    for event in events:
        stories[event.agent, event.caller, event.module] += _LETTER[event.status]
    return stories


TestModulesInAnyOrder = Modules.TestCase
TestModulesInAnyOrder.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)


def test_a_skill_whose_device_was_closed_fails_with_the_reason_also_where_it_pretends() -> None:
    with Bench(tiny_world(), (pretend(DRIVE),)) as bench:
        bench.cycle.board.closed.add("base_1")
        outcome = bench.run("drive", Base="base_1", Robot="robot_1", Location="box_a")

        assert outcome == Failure("drive: base_1 is closed: open it first")
        bench.cycle.board.closed.clear()
        assert isinstance(bench.run("drive", Base="base_1", Robot="robot_1", Location="box_a"), Success)
