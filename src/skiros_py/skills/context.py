"""What a primitive may reach besides its parameters: effects, questions to the user, the floor.

The way of a base is its own until it has driven it, or until it stands again; the floor below an arm, until it goes on.
"""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from copy import copy
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

import numpy as np
from shapely.geometry.base import BaseGeometry

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.listeners import Listeners
from skiros_py.ports.adapters import Ports
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.frames import Frames
from skiros_py.ports.paths import Outline, Path
from skiros_py.ports.signals import SignalReader
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.effects import Assign, Effect, effects_of, write_effects
from skiros_py.skills.conditions.pattern import NumberChange
from skiros_py.skills.pictures import Pictures
from skiros_py.world.element import Value
from skiros_py.world.names import local_name
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.skills.outcome import Outcome
    from skiros_py.skills.primitive import Execution


class Way(Protocol):
    """A path that a base wants to drive. Release it when the base stands again, or use it in a ``with``."""

    @property
    def free(self) -> bool:
        """True when no other robot is on it or has claimed it before: the base may go."""

    @property
    def blocked(self) -> bool:
        """True when somebody who is not driving stands there, or has an arm there: waiting is no use."""

    def waits_for(self) -> tuple[str, ...]:
        """Returns the ids of the robots because of which it is not free."""

    def idle(self) -> tuple[str, ...]:
        """Returns the ids of robots that stand there, and that nothing runs on: they stay there."""

    def to_leave(self) -> BaseGeometry | None:
        """Returns the floor that others wait for, if it is this robot that is to give way [m, map]; else None."""

    def refuse(self) -> None:
        """Says that the robot has no room to give way: another one may be asked to."""

    def deadlock(self) -> tuple[str, ...]:
        """Returns the ids of robots that wait for each other in a ring with this one, if none of them can give way."""

    def passed(self, legs: float) -> None:
        """Gives back what lies behind: so many legs have been driven, 1.5 being half of the second."""

    def release(self) -> None:
        """Gives the rest back; while the base still rolls, it stays taken."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


class Floor(Protocol):
    """The ways of all bases of a cell."""

    def is_driving(self, robot: str) -> bool:
        """Returns True when a robot is on its way: it will not stay where it is."""

    def ask(self, robot: str, outline: Outline, start: Pose, path: Path) -> Way:
        """Asks for the way along a path; first come, first served.

        Args:
            robot: Id of the robot.
            outline: What it covers while it drives.
            start: Where its base stands.
            path: What it is going to drive.
        """

    def stretch(self, arm: str, outline: Outline) -> tuple[str, ...]:
        """Takes the floor below a motion of an arm, until its next one; bases that ask for a way must go around it.

        Args:
            arm: Id of the arm.
            outline: Above what it moves.

        Returns:
            The ids of the robots that are on their way there: nothing is taken before they have passed.
        """

    def stretched(self, arm: str) -> Outline:
        """Returns above what an arm is or moves; nothing where it has not moved yet."""


class QuestionKind(enum.Enum):
    """What is asked for."""

    CONFIRM = "confirm"
    """Yes or no."""
    CHOOSE = "choose"
    """One of several."""
    REFILL = "refill"
    """Something to be brought; the answer says when it is done."""


@dataclass(frozen=True, slots=True)
class Question:
    """One question to a person.

    Attributes:
        id: Number of the question within the run.
        kind: What is asked for.
        text: The question, in the operator's words.
        options: The answers that are possible.
        asker: Name of the module that asks.
        time: Run time at which it was asked [s].
    """

    id: int
    kind: QuestionKind
    text: str
    options: tuple[str, ...]
    asker: str
    time: float


@dataclass(slots=True, eq=False)
class Asked:
    """A question that is open; the answer may come from any thread."""

    question: Question
    answer: str | None = None
    by: str = ""


class Questions:
    """The questions of a run that are open. Answers may be given from any thread; askers look in every cycle."""

    def __init__(self) -> None:
        self._open: dict[int, Asked] = {}
        self._books = (self._open,)  # its own open questions, and those of each whole that it is part of
        self._numbers = count(1)
        self._listeners = Listeners[[Question]]("questions")

    @property
    def open(self) -> tuple[Question, ...]:
        """The open questions, oldest first."""
        return tuple(asked.question for asked in list(self._open.values()) if asked.answer is None)

    def within(self) -> Questions:
        """Returns the questions of a part of the run; they are among these, too."""
        part, own = copy(self), dict[int, Asked]()
        vars(part).update(_open=own, _books=(own, *self._books))
        return part

    @property
    def heard(self) -> bool:
        """True when a listener answers: else a question would wait for ever."""
        return bool(self._listeners)

    def subscribe(self, listener: Callable[[Question], None]) -> Callable[[], None]:
        """Calls the listener with each new question; returns how to end that. It must be quick."""
        return self._listeners.add(listener)

    def ask(self, kind: QuestionKind, text: str, options: tuple[str, ...], *, asker: str, time: float) -> Asked:
        """Opens a question and tells who listens."""
        asked = Asked(Question(next(self._numbers), kind, text, options, asker, time))
        for book in self._books:
            book[asked.question.id] = asked
        self._listeners.notify(asked.question)
        return asked

    def withdraw(self, asked: Asked) -> None:
        """Closes a question that its asker no longer needs; what is answered or withdrawn already stays so."""
        for book in self._books:
            book.pop(asked.question.id, None)

    def answer(self, number: int, answer: str, *, by: str) -> None:
        """Answers a question.

        Args:
            number: Its id.
            answer: One of its options.
            by: Who answers.

        Raises:
            UnknownName: No such question is open.
            UsageError: The answer is none of its options.
        """
        asked = self._open.get(number)
        if asked is None:
            raise UnknownName("question", str(number), [str(n) for n in self._open])
        if answer not in asked.question.options:
            raise UsageError(
                "question {number}: answer one of {answers}, not '{given}'",
                number=number,
                answers=", ".join(asked.question.options),
                given=answer,
            )
        self._open.pop(number, None)
        asked.by = by
        asked.answer = answer  # last: the asker looks at this one


T = TypeVar("T")


class Clock(Protocol):
    """The time of one run of a module: it stands still while the run is paused."""

    @property
    def now(self) -> float:
        """Time [s]; only differences mean anything."""


Caller = Callable[[str, Mapping[str, Any]], "Execution[Outcome]"]
"""How a module calls another one, whose parameters may be left to inference; tick the run to its end, or close it."""


def _no_manager(module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:  # noqa: ARG001 - the port's signature
    raise RuntimeError(f"{module} cannot be called from here: no skill manager runs this")


@dataclass(slots=True, eq=False)
class Tried:
    """What was tried in vain for one purpose: kept over retries and new plans, so that the next attempt differs.

    Attributes:
        options: How often each option was tried, by what it is a choice of ("grasp", "view") and its number.
        texts: What was tried, for a person, each thing once.
    """

    options: Counter[tuple[str, int]] = field(default_factory=Counter)
    texts: dict[str, None] = field(default_factory=dict)

    def fresh(self, choice: str, options: Iterable[int]) -> list[int]:
        """Returns the options that were tried least often, in their order."""
        counts = {option: self.options[choice, option] for option in options}
        return [option for option, count in counts.items() if count == min(counts.values())]

    def note(self, choice: str, option: int, text: str) -> None:
        """Remembers that an option was tried in vain."""
        self.options[choice, option] += 1
        self.texts[text] = None

    def as_json(self) -> dict[str, list[int]]:
        """Returns the options that were tried as plain data, by what they are a choice of."""
        choices = dict.fromkeys(choice for choice, _ in self.options)
        return {choice: sorted(option for one, option in self.options if one == choice) for choice in choices}


@dataclass(frozen=True, slots=True)
class RunContext:
    """One run: its world, devices, adapters, random numbers.

    Attributes:
        world: The live world model.
        board: Snapshot and commands of the current cycle.
        ports: The adapters; see :meth:`port`.
        cell: The cell's description (limits, joints, footprint) as brought up.
        frames: Where robots, links and devices are in a cycle.
        rng: Random numbers of this run; every random choice comes from here.
        lockstep: True when simulated time waits for workers.
        report: Takes (module, progress code, text).
        clock: The time of this module's run.
        questions: Where a person is asked.
        call: Runs another module.
        emit: Takes (name of an event, value as plain data).
        effects: The effects of the skill that this module is part of; None for a module that runs on its own.
        floor: Who may drive where.
        signals: The signals of the current cycle.
        waiting: Says, for as long as it is entered, that a long wait for a worker is no fault.
        tried: What was tried in vain for the same purpose, by earlier runs too.
        pictures: The depth pictures that were taken.
        ahead: Ids of what the next steps of the plan are about; empty where nobody knows.
    """

    world: World
    board: DeviceBoard
    ports: Ports
    cell: CellSpec
    frames: Frames
    rng: np.random.Generator
    lockstep: bool
    clock: Clock
    questions: Questions
    floor: Floor
    signals: SignalReader
    waiting: Callable[[], AbstractContextManager[None]]
    report: Callable[[str, int, str], None] = lambda _module, _code, _text: None
    emit: Callable[[str, Any], None] = lambda _event, _value: None
    call: Caller = _no_manager
    effects: Effects | None = None
    tried: Tried = field(default_factory=Tried)
    pictures: Pictures = field(default_factory=Pictures)
    ahead: frozenset[str] = frozenset()

    @property
    def now(self) -> float:
        """Time of this run [s]: it stands still while the run is paused, so that a trajectory waits, too."""
        return self.clock.now

    def sleep(self, seconds: float) -> Execution[None]:
        """Ticks until so much time of this run has passed [s]: ``yield from self.context.sleep(0.5)``."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            yield

    def port(self, protocol: Callable[..., T], device: str | None = None) -> T:
        """Returns the adapter for a device: ``context.port(ArmPlanner, "panda_1")``.

        Args:
            protocol: The port's protocol.
            device: Id of the device; None for an adapter that needs none.

        Raises:
            DeviceError: None of the installed adapters serves it, or the cell is without physics and has none.
        """
        return self.ports.port(protocol, device)


class Effects:
    """The effects of one run of a skill.

    Args:
        world: The live world.
        post: The postconditions, over the skill's parameters.
        arguments: The skill's parameters in this run; filled in as they become known.
    """

    def __init__(self, world: World, post: Iterable[Condition], arguments: Mapping[str, Any]) -> None:
        self._world = world
        self._post = {condition.key: condition for condition in post}
        self._arguments = arguments

    def write(self, *keys: str, author: str, reason: str, sensed: Value | None = None, pretended: bool = False) -> None:
        """Writes some postconditions into the world, after they were sensed.

        Args:
            *keys: Their keys (:attr:`Condition.key`); none at all means every postcondition.
            author: Who sensed it.
            reason: What was sensed ("gap 44 mm, force 30 N").
            sensed: The value that was sensed of the one property they speak of: it is written, whether it is what the
                postcondition asks for or not.
            pretended: Whether a fake writes them: numbers then become what plans count on.

        Raises:
            UnknownName: The skill has no postcondition of such a key.
            UsageError: A postcondition leaves a number open ("at least 8", "grows by 30"), and no value was sensed; or
                they do not speak of one property.
            WorldError: The world refused it.
        """
        for key in keys:
            if key not in self._post:
                raise UnknownName("postcondition", key, self._post)
        wanted = [self._post[key] for key in keys] if keys else list(self._post.values())
        with self._world.transaction(author=author, reason=reason) as tx:
            effects = [effect for one in wanted for effect in effects_of(one.bind(self._arguments))]
            if not pretended:
                effects = _with_sensed(effects, sensed)
            write_effects(tx, self._world.ontology, effects)


def _with_sensed(effects: Sequence[Effect], sensed: Value | None) -> list[Effect]:
    """Returns the effects with a sensed value in the place of what a postcondition says of it."""
    valued = [effect for effect in effects if isinstance(effect, Assign | NumberChange)]
    about = {(effect.subject, effect.property) for effect in valued}
    if sensed is not None and len(about) != 1:
        raise UsageError(
            f"{sensed!r} was sensed, but the effects speak of {len(about)} properties: assert one by its key"
        )
    open_ = [effect for effect in valued if isinstance(effect, NumberChange) or effect.op != "="]
    if sensed is None and open_:
        name, subject = local_name(open_[0].property), open_[0].subject
        raise UsageError(f"the {name} of {subject} is not said by the postcondition: assert it with sensed=…")
    if sensed is None:
        return list(effects)
    others = [effect for effect in effects if not isinstance(effect, Assign | NumberChange)]
    return [*others, *(Assign(property_, subject, sensed) for subject, property_ in about)]
