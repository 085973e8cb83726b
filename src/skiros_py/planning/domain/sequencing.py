"""Sequence and work numbers in PDDL: static facts about places, and one fluent for each robot's progress.

Moving a robot to a numbered place requires that it does not precede the robot's current position in the sequence;
nothing is added if the scene's numbers do not apply. Costs come from the numbers: to go from a to b costs |a - b| + 1.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import count, product

from skiros_py.planning.domain.goals import FINISHED
from skiros_py.planning.domain.literals import Conjunction, joined
from skiros_py.planning.domain.model import Action, Atom, Variable
from skiros_py.planning.domain.pddl import LEARNED_COST, NameMap, PddlTexts, PddlWriter
from skiros_py.planning.experience import cost_table
from skiros_py.planning.problem.reachability import USUAL
from skiros_py.planning.problem.task import PlanningTask, extended
from skiros_py.planning.robots.allocation import moved_by
from skiros_py.planning.sequence import counts, sequence_number, turn_of, turns_of_goal
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import LOCATION, ROBOT

GOES_ON_FROM = "goes on from"
"""Predicate: the place whose number is the lowest that a robot may still visit."""
IN_ORDER = "in order"
"""Predicate: the second of two places has no lower number than the first."""
UNNUMBERED = "unnumbered"
"""Predicate: the place has no number."""
TURN = "turn"
"""Predicate, with its number: things placed there are placed in that turn."""

_MOST_WAYS = 32
"""Maximum number of alternatives for the conditions before a later turn: each is a variant of the action."""


def in_sequence(task: PlanningTask, reached: Mapping[str, int] | None = None) -> PlanningTask:
    """Returns the task with sequence and work numbers enforced; unchanged if they do not apply.

    Args:
        task: The task.
        reached: The highest number that each robot has visited in this task.
    """
    return _with_turns(_with_numbers(task, reached or {})) if counts(task.view) else task


# ------------------------------------------------------------ sequence numbers


def _with_numbers(task: PlanningTask, reached: Mapping[str, int]) -> PlanningTask:
    numbers = _Numbers(task)
    actions = tuple(a for action in task.domain.actions for a in numbers.variants(action))
    if actions == task.domain.actions or not numbers.of:
        return task
    facts = {Atom(UNNUMBERED, (place,)) for place in numbers.free} | numbers.order() | numbers.starts(reached)
    return extended(task, actions, facts)


class _Numbers:
    """The numbers of a task's places, and their effect on its actions."""

    def __init__(self, task: PlanningTask) -> None:
        view = task.view
        ontology = view.ontology
        self._ontology = ontology
        places = [o for o, class_ in task.problem.objects.items() if ontology.is_a(class_, LOCATION)]
        numbered = {place: sequence_number(view, place) for place in places}
        self.of = {place: number for place, number in numbered.items() if number is not None}
        self.free = [place for place in places if place not in self.of]
        self._robots = [o for o, class_ in task.problem.objects.items() if ontology.is_a(class_, ROBOT)]

    def variants(self, action: Action) -> tuple[Action, ...]:
        """Returns the variants of an action that moves a robot, for numbered and unnumbered places."""
        robots = [(m, p) for m, p in moved_by(action, self._ontology) if self._is_robot(action.types[m])]
        if not robots or not self.of:
            return (action,)
        (robot, place), *_ = robots
        last = Variable(f"{place}_last", action.types[place])
        before, now = Atom(GOES_ON_FROM, (robot, last.name)), Atom(GOES_ON_FROM, (robot, place))
        free = replace(action, pre=(*action.pre, Atom(UNNUMBERED, (place,))))
        numbered = replace(
            action,
            name=f"{action.name}/in sequence",
            parameters=(*action.parameters, last),
            pre=(*action.pre, before, Atom(IN_ORDER, (last.name, place))),
            add=(*action.add, now),
            delete=(*action.delete, before),
            notes=(*action.notes, f"parameter {last.name}: no place is visited that has a lower sequence number"),
        )
        return (free, numbered) if self.free else (numbered,)

    def order(self) -> set[Atom]:
        """Facts stating which place does not precede which."""
        return {Atom(IN_ORDER, (a, b)) for a, one in self.of.items() for b, other in self.of.items() if one <= other}

    def starts(self, reached: Mapping[str, int]) -> set[Atom]:
        """Each robot's initial position in the sequence; one that is past all places may visit none of them."""
        ahead = {r: [(n, p) for p, n in self.of.items() if n >= reached.get(r, n)] for r in self._robots}
        return {Atom(GOES_ON_FROM, (robot, min(places)[1])) for robot, places in ahead.items() if places}

    def _is_robot(self, class_: str) -> bool:
        return class_ not in ("", "object") and self._ontology.is_a(class_, ROBOT)


# ------------------------------------------------------------ work numbers


def _with_turns(task: PlanningTask) -> PlanningTask:
    view = task.view
    turns = turns_of_goal(view, task.conditions)
    numbers = sorted({turn[0] for turn in turns if turn is not None})
    ontology = view.ontology
    places = {
        o: _turn(view, o, numbers) for o, class_ in task.problem.objects.items() if ontology.is_a(class_, LOCATION)
    }
    if not any(places.values()):
        return task
    wanted = [(turn[0], _wish(task, part)) for part, turn in enumerate(turns) if turn is not None]
    placing = {a.name: [p for m, p in moved_by(a, ontology) if a.types[m] not in ("", "object")
                        and not ontology.is_a(a.types[m], ROBOT)] for a in task.domain.actions}  # fmt: skip
    needs = [
        _together([wish for number, wish in wanted if number in numbers[:rank]]) for rank in range(len(numbers) + 1)
    ]
    actions = tuple(b for a in task.domain.actions for b in _turns(a, placing[a.name], needs, places, task))
    facts = {Atom(f"{TURN} {rank + 1}", (place,)) for place, rank in places.items()}
    return extended(task, actions, facts)


def _turn(view: WorldView, place: str, numbers: Sequence[int]) -> int:
    """Returns how many of the goal's numbers come before a place; none if it has no number."""
    turn = turn_of(view, place)
    return 0 if turn is None else sum(number < turn[0] for number in numbers)


def _wish(task: PlanningTask, part: int) -> tuple[Conjunction, ...]:
    """Returns some of the ways in which a goal condition can hold, over changeable and static facts.

    Bookkeeping facts are expanded. With very many ways the wish is omitted: planned steps may then come too early,
    which the replay detects.
    """
    names = (f"_goal_{part + 1}_{number}" for number in count(1))
    return _ways(task, task.goal[part][1], names) or (Conjunction(),)


def _ways(task: PlanningTask, atoms: Sequence[Atom], names: Iterator[str]) -> tuple[Conjunction, ...]:
    """Returns each way to make all of some atoms true; none if these would be too many."""
    found: tuple[Conjunction, ...] = (Conjunction(),)
    for atom in atoms:
        own = _ways_of_one(task, atom, names)
        found = tuple(joined(pair) for pair in product(found, own))
        if not 0 < len(found) <= _MOST_WAYS:
            return ()
    return found


def _ways_of_one(task: PlanningTask, atom: Atom, names: Iterator[str]) -> tuple[Conjunction, ...]:
    closing = [(a, e) for a in task.domain.actions if a.skill is None for e in a.add if e.predicate == atom.predicate]
    if atom == FINISHED:
        return (Conjunction(),)
    if not closing:
        return (Conjunction((atom,)),)
    found: list[Conjunction] = []
    for action, effect in closing:
        bound = dict(zip(effect.arguments, atom.arguments, strict=True))
        name = next(names)
        free = {v.name: Variable(f"{v.name}{name}", v.type) for v in action.parameters if v.name not in bound}
        binding = bound | {old: new.name for old, new in free.items()}
        below = _ways(task, [pre.bind(binding) for pre in action.pre], names)
        if not below:
            return ()
        found += [joined((Conjunction((), tuple(free.values())), way)) for way in below]
    return tuple(found)


def _together(wishes: Sequence[Sequence[Conjunction]]) -> tuple[Conjunction, ...]:
    """Returns the ways to fulfil all wishes; those with the most alternatives are omitted if there are too many."""
    found: tuple[Conjunction, ...] = (Conjunction(),)
    for ways in sorted(wishes, key=len):
        if len(found) * len(ways) > _MOST_WAYS:
            break
        found = tuple(joined(pair) for pair in product(found, ways))
    return found


def _turns(
    action: Action,
    places: Sequence[str],
    needs: Sequence[Sequence[Conjunction]],
    turns: Mapping[str, int],
    task: PlanningTask,
) -> Iterator[Action]:
    """Yields the variants of an action per turn; the action itself if it places nothing with a turn."""
    fitting = {p: {t for o, t in turns.items() if task.fits(o, action.types[p])} for p in places}
    late = [place for place in places if fitting[place] - {0}]
    if not late:
        yield action
        return
    place = late[0]
    for rank in sorted(fitting[place]):
        turn = Atom(f"{TURN} {rank + 1}", (place,))
        for number, way in enumerate(needs[rank], start=1):
            name = action.name if rank == 0 else f"{action.name}/{TURN} {rank + 1}"
            name += f"/way {number}" if number > 1 else ""
            pre = tuple(dict.fromkeys((*action.pre, turn, *way.atoms)))
            yield replace(action, name=name, parameters=(*action.parameters, *way.variables), pre=pre)


# ------------------------------------------------------------ costs


def write_with_costs(task: PlanningTask, *, name: str) -> PddlTexts:
    """Writes a task with costs to be minimized; a classical one if there are none.

    Costs are those of moving through the sequence numbers; without numbers, those that were learned.

    Args:
        task: The task in sequence.
        name: Name of the problem (made a PDDL name).
    """
    if any(_leg(action) for action in task.domain.actions):
        return _SequenceWriter(task, name).texts()
    tables = {action.name: table for action in task.domain.actions if (table := cost_table(task, action))}
    writer = _LearnedCostWriter(task, name, tables) if tables else PddlWriter(task.domain, task.problem, name)
    return writer.texts()


class _CostWriter(PddlWriter, ABC):
    metric = "minimize (total-cost)"

    def requirements(self) -> tuple[str, ...]:
        return (*super().requirements(), ":action-costs")

    def functions(self) -> list[str]:
        return ["(total-cost) - number", *super().functions()]

    def init(self) -> list[str]:
        return ["(= (total-cost) 0)", *super().init()]

    def effects(self, action: Action, names: NameMap) -> list[str]:
        cost = self.cost(action, names)
        return super().effects(action, names) + ([f"(increase (total-cost) {cost})"] if cost else [])

    @abstractmethod
    def cost(self, action: Action, names: NameMap) -> str:
        """Returns what an action costs; empty for nothing."""


class _SequenceWriter(_CostWriter):
    def __init__(self, task: PlanningTask, name: str) -> None:
        super().__init__(task.domain, task.problem, name)
        self._view = task.view
        self._cost = self.other_names.pddl("sequence-cost")

    def functions(self) -> list[str]:
        total, *others = super().functions()
        return [total, f"({self._cost} ?x1 ?x2 - object) - number", *others]

    def init(self) -> list[str]:
        places = sorted({o for atom in self.problem.init if atom.predicate == IN_ORDER for o in atom.arguments})
        numbers = {self.objects.pddl(place): sequence_number(self._view, place) or 0 for place in places}
        pairs = ((a, b, one, other) for a, one in numbers.items() for b, other in numbers.items() if one <= other)
        values = (f"(= ({self._cost} {a} {b}) {other - one + 1})" for a, b, one, other in pairs)
        total, *others = super().init()
        return [total, *values, *others]

    def cost(self, action: Action, names: NameMap) -> str:
        leg = " ".join(f"?{names.pddl(place)}" for place in _leg(action))
        return f"({self._cost} {leg})" if leg else ""


def _leg(action: Action) -> tuple[str, ...]:
    """Returns the numbered places from and to which an action moves; none if it does not."""
    return next((a.arguments for a in action.pre if a.predicate == IN_ORDER), ())


_UNIT = 0.1
"""Unit of the costs, which are integers [s]."""


class _LearnedCostWriter(_CostWriter):
    """Writes expected times as costs, in tenths of a second.

    Args:
        task: The task.
        name: Name of the problem.
        tables: Costs of the actions that depend on elements, by action name: the variables and their values [s].
    """

    def __init__(
        self,
        task: PlanningTask,
        name: str,
        tables: Mapping[str, tuple[tuple[str, ...], Mapping[tuple[str, ...], float]]],
    ) -> None:
        super().__init__(task.domain, task.problem, name)
        self._tables = tables
        self._names = {action: self.other_names.pddl(f"{LEARNED_COST}-{action}") for action in tables}

    def functions(self) -> list[str]:
        total, *others = super().functions()
        own = []
        for action, (variables, _) in self._tables.items():
            own.append(f"({self._names[action]} {self.columns(variables)}) - number")
        return [total, *own, *others]

    def init(self) -> list[str]:
        values = []
        for action, (_, costs) in self._tables.items():
            for elements, seconds in costs.items():
                values.append(f"(= {self.applied(self._names[action], elements)} {_rounded(seconds)})")
        total, *others = super().init()
        return [total, *values, *others]

    def cost(self, action: Action, names: NameMap) -> str:
        if action.skill is None:
            return ""
        if action.name not in self._tables:
            known = action.duration if action.costs is None else action.seconds({})
            return str(_rounded(USUAL if known is None else known))
        return self.applied(self._names[action.name], self._tables[action.name][0], names)


def _rounded(seconds: float) -> int:
    return max(1, round(seconds / _UNIT))
