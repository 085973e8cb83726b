"""Selects the stock a goal can use: only as many interchangeable things as needed are shown (paper §6.3)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import islice

from skiros_py.planning.domain.goals import asked_emptiness
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.lifted import Lifted
from skiros_py.skills.conditions import AllOf, AnyOf, Condition, Exists, Not, Nothing, Pattern, Verdict, judge
from skiros_py.world.stock import Stock, Stocked, is_token, stocks
from skiros_py.world.view import WorldView

_SPARE = 2
"""How many more than the goal mentions: a skill may use one up, and a place with stock is not empty."""
_MOST = 100
"""Maximum number of things of one stock that plans can handle."""


def with_stock(
    view: WorldView, goal: Sequence[Condition] = (), named: Iterable[str] = (), *, whole: bool = False
) -> WorldView:
    """Returns the world with the things of its stocks that may matter; the world itself where it has no stock.

    Args:
        view: The world.
        goal: The goal.
        named: Tokens that a plan already uses: these are shown first, as far as the stock lasts.
        whole: True to show more than the goal mentions, up to what any plan can handle.
    """
    found = stocks(view)
    if not found:
        return view
    spoken = tuple(dict.fromkeys(named))
    patterns = [condition.closed_pattern(view.ontology) for condition in goal]
    return Stocked(view, {stock: _shown(stock, view, patterns, spoken, whole) for stock in found})


def lacks_stock(view: WorldView) -> bool:
    """Returns whether a world from :func:`with_stock` has more of a stock than it shows."""
    return isinstance(view, Stocked) and view.short


def believed(condition: Condition, view: WorldView) -> Verdict:
    """Returns whether a condition holds in the world model, including things without individuals."""
    return judge(condition, with_stock(view, (condition,)))


def tokens_of(steps: Iterable[Step]) -> tuple[str, ...]:
    """Returns the tokens that steps use, in order."""
    return tuple(
        dict.fromkeys(a for step in steps for a in step.arguments.values() if isinstance(a, str) and is_token(a))
    )


def _shown(
    stock: Stock, view: WorldView, patterns: Iterable[Pattern], named: Sequence[str], whole: bool
) -> tuple[str, ...]:
    own = [name for name in named if name.startswith(stock.token(0)[:-1])][: stock.count]
    wanted = _MOST if whole else _SPARE + sum(_used(p, stock, view, wanted=True) for p in patterns)
    number = int(max(len(own), min(stock.count, wanted, _MOST)))
    others = (stock.token(n) for n in range(1, stock.count + 1) if stock.token(n) not in own)
    return (*own, *islice(others, number - len(own)))


def _used(pattern: Pattern, stock: Stock, view: WorldView, *, wanted: bool) -> float:
    """Returns how many things of a stock a pattern can involve at once; infinite if it involves all.

    Args:
        pattern: The pattern.
        stock: The stock.
        view: The world.
        wanted: True if it must hold, False if it must not.
    """
    match pattern:
        case Not(inner):
            return _used(inner, stock, view, wanted=not wanted)
        case AllOf(patterns) | AnyOf(patterns):
            return sum(_used(part, stock, view, wanted=wanted) for part in patterns)
        case Exists(_, class_, inner):
            own = view.ontology.is_a(stock.class_, class_)
            within = _used(inner, stock, view, wanted=wanted)
            if wanted:
                return within + own
            return math.inf if own else within and within * len(view.instances(class_))
        case Nothing(relation, _) if wanted and stock.placement.relation in view.ontology.sub_relations(relation):
            return math.inf
        case _:
            return 0


_OWN = "#"
"""Placeholder for a thing itself in facts about it; never a valid id."""

_Sign = tuple[str, frozenset[tuple[str, tuple[str, ...]]]]


def superfluous(
    objects: Mapping[str, str],
    init: Iterable[Atom],
    actions: Sequence[Action],
    goal: Iterable[Atom],
    lifted: Lifted,
    named: Collection[str],
) -> frozenset[str]:
    """Returns the elements that no plan needs, since there are others with identical facts.

    Only things are left out on which actions help nothing but conditions about that very thing: a plan without idle
    steps then handles at most as many as the goal's own variables stand for.

    Args:
        objects: The elements, with their classes.
        init: What holds at the start.
        actions: The actions of the task.
        goal: The goal.
        lifted: The same actions.
        named: Elements that the task names.
    """
    variables = _chosen(actions, goal)
    wanted = {
        type_: sum(number for class_, number in variables.items() if lifted.overlap(type_, class_))
        for type_ in sorted(set(objects.values()))
    }
    passive = {type_ for type_ in wanted if wanted[type_] and lifted.is_passive(type_)}
    facts = tuple(init)
    standing = _in_the_way(facts, objects, actions, lifted)
    alike: dict[_Sign, list[str]] = {}
    free = [o for o, type_ in objects.items() if type_ in passive and o not in named and o not in standing]
    for thing, sign in signs(free, objects, facts).items():
        alike.setdefault(sign, []).append(thing)
    return frozenset(thing for (type_, _), things in alike.items() for thing in sorted(things)[wanted[type_] :])


def _chosen(actions: Sequence[Action], goal: Iterable[Atom]) -> Counter[str]:
    """Returns how many elements of each class the goal's variables stand for at once.

    A variable under "for all" stands for another element each time: its action is needed once for each fact that it
    achieves. An action for an inner part of the goal comes before those that need it.
    """
    times = Counter(atom.predicate for atom in goal)
    chosen: Counter[str] = Counter()
    for action in reversed([action for action in actions if action.skill is None]):
        (reached,) = action.add
        for atom in action.pre:
            times[atom.predicate] += times[reached.predicate]
        for variable in action.parameters:
            if variable.name not in reached.arguments:
                chosen[variable.type] += times[reached.predicate]
    return chosen


def _in_the_way(
    init: Iterable[Atom], objects: Mapping[str, str], actions: Iterable[Action], lifted: Lifted
) -> frozenset[str]:
    """The things in places that may be required to be empty."""
    asked: dict[str, set[str]] = {}
    for one in asked_emptiness(actions):
        asked.setdefault(one.relation, set()).add(one.class_)
    return frozenset(
        atom.arguments[0]
        for atom in init
        if any(lifted.overlap(class_, objects[atom.arguments[1]]) for class_ in asked.get(atom.predicate, ()))
    )


def signs(things: Iterable[str], objects: Mapping[str, str], init: Iterable[Atom]) -> dict[str, _Sign]:
    """Returns the class of each thing and the facts about it, without its name: equal for interchangeable things."""
    said: dict[str, set[tuple[str, tuple[str, ...]]]] = {thing: set() for thing in things}
    for atom in init:
        for thing in said.keys() & set(atom.arguments):
            own = tuple(_OWN if argument == thing else argument for argument in atom.arguments)
            said[thing].add((atom.predicate, own))
    return {thing: (objects[thing], frozenset(facts)) for thing, facts in said.items()}
