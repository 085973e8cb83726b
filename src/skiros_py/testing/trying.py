"""Runs a single skill or primitive in one call, with faults, answers and given plans where a test needs them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, Self

from skiros_py.catalogue import load_catalogue
from skiros_py.errors import UnknownName
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable
from skiros_py.plugins.installation import installation
from skiros_py.ports.adapters import NO_PORTS, Ports
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.values import Done
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.context import Question, Questions
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing.bench import Bench
from skiros_py.testing.faulty_cell import CellFault, FaultyCell
from skiros_py.world.change import Change
from skiros_py.world.scene.files import describe
from skiros_py.world.world import World


class Answers:
    """The questions of a run, and those without an answer.

    Attributes:
        asked: Every question so far.
        unanswered: Questions that match no given answer; they stay open.
    """

    def __init__(self, questions: Questions, given: Mapping[str, str]) -> None:
        self.asked: list[Question] = []
        self.unanswered: list[Question] = []
        self._questions = questions
        self._given = given
        questions.subscribe(self._hear)

    def _hear(self, question: Question) -> None:
        self.asked.append(question)
        fitting = [answer for words, answer in self._given.items() if words in question.text]
        if fitting:
            self._questions.answer(question.id, fitting[0], by="test")
        else:
            self.unanswered.append(question)


def answers(questions: Questions, given: Mapping[str, str]) -> Answers:
    """Answers the questions of a run to a person, from now on.

    >>> asked = answers(bench.questions, {"refill": "done", "Is the door open": "yes"})

    Args:
        questions: Of a bench or a session.
        given: Answer by words contained in the question; the first match is used.

    Returns:
        The questions so far.
    """
    return Answers(questions, given)


class GivenPlanner:
    """A :class:`~skiros_py.planning.planners.planner.Planner` that does not read its task.

    Args:
        *steps: PDDL action with its objects, as one text each ("drive base_1 robot_1 box_a unknown_location"); none
            at all for the answer that there is no plan.
    """

    name = "given"
    supports = frozenset({":strips", ":typing", ":negative-preconditions", ":existential-preconditions"})

    def __init__(self, *steps: str) -> None:
        self._answer: Answer = Solved(tuple(tuple(step.split()) for step in steps)) if steps else Unsolvable()

    def solve(self, domain: str, problem: str) -> Done[Answer]:  # noqa: ARG002 - the port's signature
        """Answers."""
        return Done(self._answer)

    def close(self) -> None:
        """Does nothing; there is nothing to kill."""


@dataclass(frozen=True, slots=True, repr=False)
class SkillTrial:
    """The result of running a module; true if it succeeded.

    Attributes:
        module: Its name.
        outcome: How it ended.
        events: Module events during the run.
        changes: Changes of the world during the run.
        seconds: Duration, in time of the run [s].
        verdicts: Whether its postconditions hold afterwards, with reasons, by their keys' order; none of a primitive.
        questions: The questions to a person.
    """

    module: str
    outcome: Outcome
    events: tuple[ModuleEvent, ...]
    changes: tuple[Change, ...]
    seconds: float
    verdicts: tuple[Verdict, ...] = ()
    questions: tuple[Question, ...] = ()

    @property
    def succeeded(self) -> bool:
        """True when it succeeded."""
        return isinstance(self.outcome, Success)

    @property
    def reason(self) -> str:
        """Why it failed, or its message upon success."""
        return self.outcome.message if isinstance(self.outcome, Success) else self.outcome.reason

    def check(self) -> Self:
        """Returns itself if it succeeded.

        Raises:
            AssertionError: It failed; with the reasons, the events and the changes.
        """
        if not self.succeeded:
            raise AssertionError(str(self))
        return self

    def lines(self) -> list[str]:
        """Returns all of it as lines."""
        return [
            f"{self.module} {'succeeded' if self.succeeded else 'failed'} after {self.seconds:.2f} s: {self.reason}",
            *_section("postconditions", [line for verdict in self.verdicts for line in verdict.lines()]),
            *_section("events", [_event(event) for event in self.events]),
            *_section("changes", [line for change in self.changes for line in _change(change)]),
            *_section("questions", [question.text for question in self.questions]),
        ]

    def __bool__(self) -> bool:
        return self.succeeded

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def __repr__(self) -> str:
        return f"<{self.module} {'succeeded' if self.succeeded else 'failed'}: {self.reason}>"


def _section(title: str, lines: list[str]) -> list[str]:
    return [f"  {title}:", *(f"    {line}" for line in lines)] if lines else []


def _event(event: ModuleEvent) -> str:
    code = f" ({event.code})" if event.status in (Status.RUNNING, Status.ERROR) else ""
    return f"{event.time:7.3f} s  {event.kind} {event.module}: {event.status.value}{code} {event.text}".rstrip()


def _change(change: Change) -> list[str]:
    head = f"{change.time:7.3f} s  {change.author}: {change.reason}"
    return [head, *(f"           {line}" for line in describe(change.edits))]


@dataclass(frozen=True, slots=True)
class Fails:
    """A primitive fails immediately, for a number of calls (None for all); then it works."""

    primitive: str
    reason: str = "a fault of the test"
    times: int | None = 1
    code: int = -1


@dataclass(frozen=True, slots=True)
class Breaks:
    """A primitive raises an exception, for a number of calls (None for all); then it works."""

    primitive: str
    exception: BaseException
    times: int | None = 1


@dataclass(frozen=True, slots=True)
class Slow:
    """A primitive starts with a delay [s], for a number of calls (None for all)."""

    primitive: str
    seconds: float
    times: int | None = None


ModuleFault = Fails | Breaks | Slow


def spoiled(
    primitives: Sequence[type[Primitive[Any]]], faults: Sequence[ModuleFault]
) -> tuple[type[Primitive[Any]], ...]:
    """Returns the primitives, with those that have a fault replaced by faulty ones of the same name.

    Raises:
        UnknownName: A fault is for a primitive that is not among them.
    """
    known = {primitive.name: primitive for primitive in primitives}
    for fault in faults:
        if fault.primitive not in known:
            raise UnknownName("primitive", fault.primitive, known, where=f"in {fault}")
        known[fault.primitive] = _with_fault(known[fault.primitive], fault)
    return tuple(known.values())


def _with_fault(primitive: type[Primitive[Any]], fault: ModuleFault) -> type[Primitive[Any]]:
    calls = count(1)

    class Spoiled(primitive):  # type: ignore[valid-type,misc]  # a class made at run time
        __doc__ = primitive.__doc__

        def execute(self) -> Execution[Outcome]:
            if fault.times is None or next(calls) <= fault.times:
                match fault:
                    case Fails():
                        return Failure(fault.reason, fault.code)
                    case Breaks():
                        raise fault.exception
                    case Slow():
                        end = self.context.now + fault.seconds
                        while self.context.now < end:
                            yield
            outcome: Outcome = yield from super().execute()
            return outcome

    Spoiled.__name__, Spoiled.__qualname__ = primitive.__name__, primitive.__qualname__
    return Spoiled


_LIMIT = 600.0
_ANY = "any"
"""A kind of driver for which there is no implementation: those that are for every kind are used."""

Fault = CellFault | ModuleFault
"""Of a device or of a primitive."""
Driver = str | Callable[[CellSpec], CellDriver]
"""Kind of cell: "fake", "pybullet" or "mujoco", a name of the group ``skiros.drivers``, or what brings one up."""


def run_skill(
    skill: Skill,
    world: World,
    *,
    primitives: Sequence[type[Primitive[Any]]] = (),
    skills: Sequence[Skill] = (),
    driver: Driver = "fake",
    faults: Sequence[Fault] = (),
    answers: Mapping[str, str] | None = None,
    ports: Ports = NO_PORTS,
    config: Mapping[str, Any] | None = None,
    limit: float = _LIMIT,
    **arguments: Any,
) -> SkillTrial:
    """Runs one implementation of a skill to its end, as fast as possible, and returns all data of the run.

    >>> trial = run_skill(PARK, tiny_world(), primitives=[BackOff], faults=[Fails("back_off")], Place="floor")

    Args:
        skill: The implementation, whichever driver it is for.
        world: Where it runs; it is changed.
        primitives: Primitives that its body uses.
        skills: Further skills that it calls.
        driver: Kind of cell: "fake", "pybullet", the name of a plug-in's driver, or what brings one up.
        faults: Faults of devices and primitives.
        answers: Answers of a person; see :func:`skiros_py.testing.answers`.
        ports: Adapters, for primitives that use them; see :class:`skiros_py.ports.adapters.GivenPorts`.
        config: Values of configuration parameters by "module.key".
        limit: Maximum time of the run [s], after which it is stopped and fails.
        **arguments: Values by parameter key; what is left out is inferred.

    Raises:
        UnknownName: A fault is for a device or primitive that is not there, or no robot can do it.
        DeviceError: The cell broke (:class:`~skiros_py.testing.Dies`).
    """
    offered = [replace(one, driver=None) for one in (skill, *skills)]
    with _bench(world, offered, primitives, driver, faults, ports, config) as bench:
        trial, values = _try(bench, skill.description.name, arguments, answers or {}, limit)
    return replace(trial, verdicts=tuple(_verdict(post, world, values) for post in skill.description.post))


def run_primitive(
    primitive: type[Primitive[Any]],
    world: World,
    *,
    primitives: Sequence[type[Primitive[Any]]] = (),
    driver: Driver = "fake",
    faults: Sequence[Fault] = (),
    answers: Mapping[str, str] | None = None,
    ports: Ports = NO_PORTS,
    config: Mapping[str, Any] | None = None,
    limit: float = _LIMIT,
    **params: Any,
) -> SkillTrial:
    """Runs one primitive to its end, as fast as possible, and returns all data of the run; see :func:`run_skill`.

    >>> trial = run_primitive(BackOff, tiny_world(), base="base_1", robot="robot_1", place="floor", seconds=0.5)

    Args:
        primitive: Its class.
        world: Where it runs; it is changed.
        primitives: Further ones that it calls.
        driver: Kind of cell: "fake", "pybullet", the name of a plug-in's driver, or what brings one up.
        faults: Faults of devices and primitives.
        answers: Answers of a person.
        ports: Adapters, for primitives that use them; see :class:`skiros_py.ports.adapters.GivenPorts`.
        config: Values of configuration parameters by "module.key".
        limit: Maximum time of the run [s], after which it is stopped and fails.
        **params: Its parameters; devices that are left out are those of the robot.
    """
    with _bench(world, (), (primitive, *primitives), driver, faults, ports, config) as bench:
        return _try(bench, primitive.name, params, answers or {}, limit)[0]


def _bench(
    world: World,
    skills: Sequence[Skill],
    primitives: Sequence[type[Primitive[Any]]],
    driver: Driver,
    faults: Sequence[Fault],
    ports: Ports,
    config: Mapping[str, Any] | None,
) -> Bench:
    of_modules = [fault for fault in faults if not isinstance(fault, CellFault)]
    of_devices = [fault for fault in faults if isinstance(fault, CellFault)]

    def cell(spec: CellSpec) -> CellDriver:
        own = driver(spec) if callable(driver) else _cell(driver, spec)
        return FaultyCell(own, *of_devices) if of_devices else own

    brought = [one for skill in skills for one in skill.primitives]
    spoilt = spoiled([*brought, *primitives], of_modules)
    return Bench(world, skills, spoilt, cell=cell, driver=_ANY, planner=GivenPlanner(), ports=ports, config=config)


def _cell(driver: str, spec: CellSpec) -> CellDriver:
    if any(entry.name == driver for entry in installation().of("skiros.engines")):
        from skiros_py.simulation.cell import SimulatedCell  # heavy, and rarely needed

        return SimulatedCell(spec, seed=0, engine=driver)
    return FakeCell(spec) if driver == "fake" else load_catalogue().driver(driver, spec, seed=0)


def _try(
    bench: Bench, module: str, arguments: Mapping[str, Any], given: Mapping[str, str], limit: float
) -> tuple[SkillTrial, Mapping[str, Any]]:
    """Runs a module to its end; also returns its parameters, with those that were inferred."""
    person = Answers(bench.questions, given)
    changes: list[Change] = []
    unsubscribe = bench.world.subscribe(changes.append)
    start = bench.time
    running = bench.start(module, **arguments)
    # A device that always reports motion never comes to a standstill.
    while not running.done and bench.time - start < limit + 2.0 * bench.cycle.board.braking_time:
        if bench.time - start >= limit:
            running.task.stop(f"it did not end within {limit:g} s")
        bench.cycle.step()
    unsubscribe()
    seconds, asked = bench.time - start, tuple(person.asked)
    trial = SkillTrial(module, running.result, tuple(bench.events), tuple(changes), seconds, questions=asked)
    return trial, running.arguments


def _verdict(condition: Condition, world: World, values: Mapping[str, Any]) -> Verdict:
    open_ = [key for key in condition.arguments if values.get(key) is None]
    if open_:
        return Verdict(False, f"{condition}: {', '.join(open_)} stayed unspecified")
    return condition.evaluate(world, values)
