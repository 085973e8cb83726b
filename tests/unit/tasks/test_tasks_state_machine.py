"""Random handling of several tasks on two robots while the world, the managers and the skills do what they like.

Whatever happens: a subsystem does one step at a time and a robot works for one task, every task comes to its end with
a true report, its trace tells each start and each end once, it plans a bounded number of times, and nothing stays
reserved when nothing is under way.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any, ClassVar

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Wait
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.trace import StepRun, TraceEntry, TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.element import Placement

FACTS = (
    'scene:ball_2 a tiny:Ball ; rdfs:label "ball 2" ; sk:in scene:box_b .',
    'scene:slot_3 a tiny:Slot ; rdfs:label "slot 3" ; sk:on scene:floor .',
)
GOALS = (
    ("In(ball_1, slot_1)",),
    ("In(Ball, slot_2)",),
    ("In(red_ball_1, slot_3)", "In(ball_2, slot_1)"),
    ("Holding(gripper_1, ball_2)", "At(robot_2, box_b)"),
    ("At(robot_1, box_b)",),
    ("In(ball_1, slot_1)", "In(ball_1, slot_2)"),
)
BALLS = ("ball_1", "ball_2", "red_ball_1")
PLACES = (("sk:in", "box_a"), ("sk:in", "box_b"), ("sk:in", "slot_1"), ("sk:in", "slot_2"), ("sk:on", "floor"))
SUBSYSTEMS = ("arm_1", "base_1", "arm_2", "base_2")
STARTS = {TraceEventKind.STARTED}
ENDS = {TraceEventKind.ENDED, TraceEventKind.FAILED, TraceEventKind.CANCELLED}
SECONDS = 60.0


class Fumble(Primitive[Any]):
    """Fails so often as told."""

    name: ClassVar[str] = "fumble"
    failures: ClassVar[int] = 0

    @dataclass(frozen=True, slots=True)
    class Params:
        what: str = param("sk:SpatialThing", "What it is about.")

    def execute(self) -> Execution[Outcome]:
        yield
        if Fumble.failures:
            Fumble.failures -= 1
            return Failure(f"{self.params.what} slipped")
        return Success()


SKILLS = tuple(
    pretend(skill, Sequence.of(Wait(0.1), Do.of("fumble", what=P(skill.target)), AssertEffects(0.0)))
    for skill in (DRIVE, PICK, PLACE)
)


class Watched:
    """One task, and what whoever looks on has heard of it."""

    def __init__(self, bench: Bench, task: TaskHandle, complaints: list[str]) -> None:
        self.task = task
        self.busy: dict[int, str] = {}
        self.intents: Counter[int] = Counter()
        self.answers = 0
        self._bench = bench
        self._complaints = complaints
        task.trace.subscribe(self._hear)
        task.before_step(self._intend)

    def _intend(self, run: StepRun) -> None:
        self.intents[run.number] += 1

    def _hear(self, entry: TraceEntry) -> None:
        if entry.what is TraceEventKind.STARTED and entry.step is not None:
            self.busy[entry.step] = entry.agent
        elif entry.what in ENDS and entry.step is not None:
            self.busy.pop(entry.step, None)
        elif entry.what is TraceEventKind.ANSWERED:
            self.answers += 1
        elif entry.what is TraceEventKind.FINISHED and not self._bench.cycle.halted:
            self._compare()

    def _compare(self) -> None:
        """Compares the report with what is believed at its end."""
        assert self.task.report is not None
        for told, condition in zip(self.task.report.conditions, self.task.goal, strict=True):
            if told.believed != bool(condition.evaluate(self._bench.world)):
                self._complaints.append(f"{self.task.name} reports {told}, and it is not so")

    def complaints_at_the_end(self) -> list[str]:
        """What is wrong with its trace."""
        entries = self.task.trace.entries
        starts = Counter(e.step for e in entries if e.what in STARTS)
        ends = Counter(e.step for e in entries if e.what in ENDS)
        plans = sum(e.what in (TraceEventKind.PLANNED, TraceEventKind.RETRIED) for e in entries)
        most = self.task.policy.attempts * (len(self.task.goal) + 2) * (1 + self.answers)
        found = {
            "it did not begin once, first of all": [e.what for e in entries].index(TraceEventKind.BEGUN) != 0,
            "it did not finish once, last of all": [e.what for e in entries].count(TraceEventKind.FINISHED) != 1
            or entries[-1].what is not TraceEventKind.FINISHED,
            f"starts {starts} and ends {ends} differ": starts != ends,
            f"not every step starts once: {starts}": any(n != 1 for n in starts.values()),
            f"intents {self.intents} are not the starts": self.intents != starts,
            f"{plans} plans and tries, {most} are the most": plans > most,
        }
        return [f"{self.task.name}: {text}\n{self.task.trace}" for text, wrong in found.items() if wrong]


class SeveralTasks(RuleBasedStateMachine):
    """Tasks on two robots."""

    def __init__(self) -> None:
        super().__init__()
        Fumble.failures = 0
        self.bench = Bench(tiny_world(*FACTS, robots=2), SKILLS, (Fumble,))
        self.bench.__enter__()
        self.complaints: list[str] = []
        self.watched: list[Watched] = []

    @property
    def under_way(self) -> list[TaskHandle]:
        return [one.task for one in self.watched if not one.task.done]

    def cycles(self, number: int) -> None:
        for _ in range(number):
            self.bench.cycle.step()
            busy = Counter(agent for one in self.watched for agent in one.busy.values())
            robots = Counter(robot for one in self.watched for robot in {agent[-1] for agent in one.busy.values()})
            assert all(count == 1 for count in busy.values()), f"a subsystem does several steps at once: {busy}"
            assert all(count == 1 for count in robots.values()), f"a robot works for several tasks at once: {robots}"

    # ------------------------------------------------------------------ people

    @initialize(goal=st.sampled_from(GOALS))
    def first(self, goal: tuple[str, ...]) -> None:
        self.begin(goal, ask=False, attempts=3)

    @precondition(lambda self: len(self.under_way) < 3)
    @rule(goal=st.sampled_from(GOALS), ask=st.booleans(), attempts=st.integers(1, 3))
    def begin(self, goal: tuple[str, ...], ask: bool, attempts: int) -> None:
        known = [text for text in goal if all(self.bench.world.has(b) or b not in text for b in BALLS)]
        if known:
            task = self.bench.tasks.begin(self.bench.goal(*known), policy=Policy(ask=ask, attempts=attempts))
            self.watched.append(Watched(self.bench, task, self.complaints))

    @precondition(lambda self: self.under_way)
    @rule(which=st.integers(0, 2), wish=st.sampled_from(("pause", "resume", "step", "stop", "stop")))
    def wish(self, which: int, wish: str) -> None:
        task = self.under_way[which % len(self.under_way)]
        getattr(task, wish)()
        getattr(task, wish)()  # twice is once
        self.cycles(1)

    @precondition(lambda self: self.bench.questions.open)
    @rule(choice=st.sampled_from(("retry", "done by hand", "skip", "abort")))
    def answer(self, choice: str) -> None:
        self.bench.questions.answer(self.bench.questions.open[0].id, choice, by="ann")
        self.cycles(1)

    @rule()
    def halt(self) -> None:
        assert self.bench.cycle.stop_all("somebody hit the button")
        assert not self.under_way, "after a halt every task is over"
        self.bench.cycle.reset()

    # ------------------------------------------------------------------ the world

    @rule(number=st.integers(1, 40))
    def goes_on(self, number: int) -> None:
        self.cycles(number)

    @rule(ball=st.sampled_from(BALLS), place=st.sampled_from(PLACES))
    def move(self, ball: str, place: tuple[str, str]) -> None:
        with self.bench.world.transaction("somebody", "moved it") as tx:
            if self.bench.world.has(ball):
                tx.place(ball, *place)
            else:
                tx.add("tiny:Ball", placement=Placement(*place))

    @rule(ball=st.sampled_from(BALLS))
    def remove(self, ball: str) -> None:
        world = self.bench.world
        if world.has(ball) and not world.objects(ball, "sk:heldBy"):  # what is held cannot be removed
            with world.transaction("somebody", "threw it away") as tx:
                tx.remove(ball)

    # ------------------------------------------------------------------ skills and managers

    @rule(agent=st.sampled_from(SUBSYSTEMS), how=st.sampled_from(("lose", "close", "stop")))
    def goes(self, agent: str, how: str) -> None:
        manager = self.bench.managers.get(agent)
        if manager is not None:
            {"lose": lambda: manager.lose("its host is gone"), "stop": manager.stop}.get(
                how, lambda: self.bench.managers.close(agent)
            )()
            self.cycles(1)

    @rule()
    def all_come_back(self) -> None:
        for agent in SUBSYSTEMS:
            if agent not in self.bench.managers or self.bench.managers[agent].lost:
                self.bench.managers.open(agent)

    @rule(times=st.integers(1, 4))
    def fails(self, times: int) -> None:
        Fumble.failures = times

    # ------------------------------------------------------------------ what must be so

    @invariant()
    def reports_are_true(self) -> None:
        assert not self.complaints, self.complaints

    def teardown(self) -> None:
        try:
            self._end()
        finally:
            self.bench.close()

    def _end(self) -> None:
        """Lets everything come to its end, and does something with each robot afterwards."""
        for task in self.under_way:
            task.resume()
        end = self.bench.time + SECONDS
        while self.under_way:
            for question in self.bench.questions.open:
                self.bench.questions.answer(question.id, "skip", by="ann")
            self.cycles(1)
            stuck = "\n\n".join(str(task.trace) for task in self.under_way)
            assert self.bench.time < end, f"after {SECONDS:g} s these are still under way:\n{stuck}"
        assert not self.complaints, self.complaints
        assert [text for one in self.watched for text in one.complaints_at_the_end()] == []
        assert self.bench.questions.open == ()
        self._nothing_is_left()

    def _nothing_is_left(self) -> None:
        self.all_come_back()
        Fumble.failures = 0
        self.cycles(20)  # what was cancelled at the very end may still have to brake
        task = self.bench.tasks.begin(self.bench.goal("At(robot_1, box_a)", "At(robot_2, box_a)"))
        self.bench.until(lambda: task.done, limit=5.0)
        assert task.report is not None
        assert task.report.reached, task.trace
        assert not [e for e in task.trace.entries if e.what is TraceEventKind.WAITS], task.trace
        devices = [device for agent in SUBSYSTEMS for device in (agent, agent.replace("arm", "gripper"))]
        with self.bench.managers.claims.request("the test", devices) as claim:
            assert claim.granted, claim.waits_for()


TestSeveralTasks = SeveralTasks.TestCase
# A run that fails is shown as it was found: to shrink it, every step of which plans, takes too long.
TestSeveralTasks.settings = settings(
    max_examples=10,
    stateful_step_count=18,
    deadline=None,
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large],
)
