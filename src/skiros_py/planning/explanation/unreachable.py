"""Explains why a fact never becomes true: from the skill that would provide it to the fact that no skill can change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from skiros_py.messages import Message, listed
from skiros_py.planning.domain.actions import is_placement, moved_and_place
from skiros_py.planning.domain.literals import CAN, HAS, NOT, NOTHING
from skiros_py.planning.domain.matching import is_variable
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.domain.numbers import number_compared, numbers_of
from skiros_py.planning.explanation.wording import Reason, Wording, some
from skiros_py.planning.plan import CauseKind
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.conditions import Computed
from skiros_py.world.names import local_name
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ROBOT

_SHOWN = 4
"""How many misplaced things are named."""
_COUNTED = 32
"""How many elements of a class one reason names as data."""

Types = Mapping[str, str]


class Leaves:
    """Describes the actual state for false facts."""

    def __init__(self, task: PlanningTask, wording: Wording) -> None:
        self._task = task
        self._view = task.view
        self._wording = wording

    def of(self, atom: Atom, types: Types) -> Reason:
        """Returns why a fact that no skill provides never holds."""
        if atom.predicate.startswith(CAN):
            return self._no_skill(atom, types)
        if atom.predicate.startswith(NOTHING):
            return self._full(atom, types)
        if is_placement(atom, self._view.ontology):
            return self._elsewhere(atom, types)
        if is_placement(Atom(atom.predicate.removeprefix(NOT)), self._view.ontology):
            return self._still_there(atom, types)
        return self._plainly(atom, types)

    def none_of(self, class_: str) -> Reason:
        """Returns the reason that a class has no elements."""
        return Reason(
            CauseKind.MISSING_ELEMENT, Message("there is no {kind}", kind=local_name(class_)), elements=(class_,)
        )

    def _no_skill(self, atom: Atom, types: Types) -> Reason:
        agents = self._things(atom.arguments[0], types)
        skill = atom.predicate.removeprefix(CAN)
        text = Message("{agent} does not have it", agent=agents[0])
        if len(agents) != 1:
            text = Message("{agents} do not have it", agents=listed(agents))
        return Reason(CauseKind.NO_SKILL, text, skill, "", agents, atom, types)

    def _full(self, atom: Atom, types: Types) -> Reason:
        relation = atom.predicate.removeprefix(NOTHING)
        verb = self._wording.term(relation)
        places = self._things(atom.arguments[0], types)
        there = {place: self._view.subjects(relation, place) for place in places}
        if len(places) == 1:
            text = Message(
                "{things} {relation} {place}, and no skill takes it away",
                things=listed(there[places[0]]),
                relation=verb,
                place=places[0],
            )
        else:
            kind = local_name(types.get(atom.arguments[0], "place"))
            text = Message("every {kind} is taken, and no skill takes anything away", kind=kind)
        elements = (*places, *dict.fromkeys(thing for things in there.values() for thing in things))
        return Reason(CauseKind.FULL, text, elements=elements, missing=atom, types=types)

    def _elsewhere(self, atom: Atom, types: Types) -> Reason:
        """Describes where the things are that should be in a place."""
        moved, place = moved_and_place(atom, self._view.ontology)
        things = self._things(moved, types)
        if not things:
            return self.none_of(types.get(moved, moved))
        if not self._things(place, types):
            return self.none_of(types.get(place, place))
        placed = {thing: p for thing in things[:_SHOWN] if (p := self._view.placement(thing)) is not None}
        if not placed:
            return self._plainly(atom, types)
        said = listed(self._wording.stated(thing, p.relation, p.place) for thing, p in placed.items())
        elements = tuple(dict.fromkeys((*placed, *(p.place for p in placed.values()))))
        text = Message("{said}, and no skill takes it from there", said=said)
        return Reason(CauseKind.MISSING_FACT, text, elements=elements, missing=atom, types=types)

    def _still_there(self, atom: Atom, types: Types) -> Reason:
        """Describes what is in a place where it should not be."""
        relation = atom.predicate.removeprefix(NOT)
        subjects, objects = (self._things(argument, types) for argument in atom.arguments)
        there = [(s, o) for s in subjects for o in objects if self._view.related(s, relation, o)][:_SHOWN]
        if not there:
            return self._plainly(atom, types)
        said = listed(self._wording.stated(subject, relation, object_) for subject, object_ in there)
        elements = tuple(dict.fromkeys(name for pair in there for name in pair))
        text = Message("{said}, and no skill takes it from there", said=said)
        if len(there) > 1:
            text = Message("{said}, and no skill takes them from there", said=said)
        return Reason(CauseKind.MISSING_FACT, text, elements=elements, missing=atom, types=types)

    def _plainly(self, atom: Atom, types: Types) -> Reason:
        """States that a fact is false, with the reason if known."""
        asked = self._task.asked.get(atom.predicate)
        kind = CauseKind.DOES_NOT_FIT if isinstance(asked, Computed) else CauseKind.MISSING_FACT
        named = (*(types.get(a, a) for a in atom.arguments),)
        for argument in atom.arguments:
            if not self._things(argument, types):
                return self.none_of(types.get(argument, argument))
        only = {a: things[0] for a in atom.arguments if len(things := self._things(a, types)) == 1}
        number = number_compared(atom.predicate)
        counts = number is not None and number[0] in numbers_of(self._task.domain.actions)
        said = self._instead(atom.bind(only), types)
        text = Message("{said}, and no skill changes it", said=said)
        if counts:
            text = Message("{said}, and no skill gets it there", said=said)
        return Reason(kind, text, elements=named, missing=atom, types=types)

    def _instead(self, atom: Atom, types: Types) -> str:
        if atom.predicate.startswith(HAS):
            thing, property_ = atom.arguments[0], self._wording.term(atom.predicate.removeprefix(HAS))
            if is_variable(thing):
                return Message("no {kind} has a {property}", kind=local_name(types[thing]), property=property_)
            return Message("{thing} has no {property}", thing=thing, property=property_)
        asked = self._task.asked.get(atom.predicate)
        if asked is not None and not any(is_variable(a) for a in atom.arguments):
            verdict = asked.evaluate(self._view, dict(zip(("1", "2"), atom.arguments, strict=False)))
            return verdict.text
        if isinstance(asked, Computed):
            return self._wording.none(atom, types)
        if asked is None and atom.predicate.startswith(NOT):
            return self._wording.atom(Atom(atom.predicate.removeprefix(NOT), atom.arguments), types)
        return Message("it is not true that {said}", said=self._wording.atom(atom, types))

    def _things(self, argument: str, types: Types) -> tuple[str, ...]:
        """Returns the elements an argument could be; a bounded number of them."""
        if not is_variable(argument):
            return (argument,)
        class_ = types.get(argument, "")
        if class_ in ("", "object"):
            return tuple(list(self._task.problem.objects)[:_COUNTED])
        return self._view.instances(class_)[:_COUNTED]


Chain = tuple[Atom, ...]


_DEPTH = 6
_GROUNDINGS = 6
"""Up to how many candidate things of a precondition are examined individually."""
_WAYS = 64
"""How many partial groundings of an action are compared."""
_MOST = 400
"""How many facts are examined per explanation; after that, the closest answer so far is used."""

_SPECIFIC = (
    CauseKind.FULL,
    CauseKind.DOES_NOT_FIT,
    CauseKind.MISSING_FACT,
    CauseKind.MISSING_ELEMENT,
    CauseKind.NO_SKILL,
)
"""Which reason is given if things have different ones: the one closest to working."""


@dataclass(frozen=True, slots=True)
class _Try:
    """An action that would provide a fact, and how far it gets.

    Attributes:
        action: The action.
        start: The binding given by the fact.
        types: Classes of its variables, narrowed by the fact.
        direct: The reason before any precondition; None if there is none.
        ways: Ways to make the preconditions before :attr:`stuck` true.
        stuck: The first precondition that never holds together with those.
        progress: Share of the preconditions that can hold together.
    """

    action: Action
    start: Mapping[str, str]
    types: Types
    direct: Reason | None = None
    ways: tuple[Mapping[str, str], ...] = ()
    stuck: Atom | None = None
    progress: float = 0.0


class UnreachableFacts:
    """Explains the facts that the relaxation never reaches."""

    def __init__(self, relaxation: Relaxation) -> None:
        self._relaxed = relaxation
        self._task = relaxation.task
        self._view = relaxation.task.view
        self._ontology = self._view.ontology
        self._wording = Wording(self._ontology)
        self._leaves = Leaves(self._task, self._wording)
        self._given = {e.predicate for action in self._task.domain.actions for e in action.add}
        self._left = _MOST

    def of(self, atom: Atom, types: Types | None = None, chain: Chain = ()) -> Reason:
        """Returns why a fact (perhaps with variables left) never holds.

        Args:
            atom: The fact.
            types: Classes of its variables.
            chain: The chain of facts that require this one; used to stop at cycles.
        """
        types = types or {}
        self._left -= 1
        givers = [(a, e) for a in self._task.domain.actions for e in a.add if self._could_give(a, e, atom, types)]
        if not givers or atom in chain or len(chain) == _DEPTH or self._left < 0:
            return self._without_giver(atom, types, chain)
        tries = [self._tried(action, effect, atom, types) for action, effect in givers]
        best = max(tries, key=lambda one: (one.progress, self._openness(one), self._has_elements(one)))
        if best.direct is not None:
            return replace(best.direct, missing=best.direct.missing or atom, types=best.direct.types or types)
        return self._described(best, (*chain, atom))

    def _openness(self, one: _Try) -> int:
        """Returns how near it is to working: 2 for what a skill changes or a number decides, 0 for what things are."""
        if one.stuck is None or one.stuck.predicate in self._given:
            return 2
        family = self._family(one.stuck)
        if family is Family.COMPUTED:
            return 2 if self._is_measured(one, one.stuck) else 0
        return 0 if family is Family.STRUCTURE else 1

    def _family(self, atom: Atom) -> Family | None:
        relation = atom.predicate.removeprefix(NOT)
        return self._ontology.family(relation) if relation in self._ontology.relations else None

    def _is_measured(self, one: _Try, stuck: Atom) -> bool:
        """Returns whether a number decides a computed fact for one of the ways to get there."""
        asked, reasoners = self._task.asked.get(stuck.predicate), self._view.reasoners
        facts = [stuck.bind(way).arguments for way in one.ways[:_GROUNDINGS]]
        if not isinstance(asked, Computed) or not reasoners.computes(asked.relation):
            return False
        return any(
            reasoners.answer(self._view, fact[0], asked.relation, fact[1]).value is not None
            for fact in facts
            if len(fact) == 2 and not any(map(is_variable, fact))
        )

    def _has_elements(self, one: _Try) -> bool:
        """Returns whether there is something of each class that it needs."""
        return all(self._relaxed.is_some(class_) for class_ in one.types.values())

    def _without_giver(self, atom: Atom, types: Types, chain: Chain) -> Reason:
        leaf = self._leaves.of(atom, types)
        if chain or leaf.kind is not CauseKind.MISSING_FACT:
            return leaf
        text = (
            Message("{said}, and no skill brings it about", said=leaf.text) if ", and" not in leaf.text else leaf.text
        )
        return replace(leaf, kind=CauseKind.NO_SKILL, text=text)

    def _could_give(self, action: Action, effect: Atom, atom: Atom, types: Types) -> bool:
        """Returns whether an effect is of the required kind; a wrong element is left for the reason to report.

        Of a narrower kind than required there must be something.
        """
        if effect.predicate != atom.predicate:
            return False
        own = action.types
        pairs = [
            (own[variable], types[value])
            for variable, value in zip(effect.arguments, atom.arguments, strict=True)
            if is_variable(value) and own.get(variable) and types.get(value)
        ]
        return all(
            self._ontology.is_a(b, a) or (self._ontology.is_a(a, b) and self._relaxed.is_some(a)) for a, b in pairs
        )

    # ------------------------------------------------------------ how far an action gets

    def _tried(self, action: Action, effect: Atom, atom: Atom, wanted: Types) -> _Try:
        pairs = list(zip(effect.arguments, atom.arguments, strict=True))
        start = {variable: value for variable, value in pairs if is_variable(variable) and not is_variable(value)}
        types = action.types
        for variable, value in pairs:
            if is_variable(value) and self._narrows(wanted.get(value, ""), types.get(variable, "")):
                types[variable] = wanted[value]
        direct = self._of_wrong_class(action, start, types)
        if direct is not None:
            return _Try(action, start, types, direct)
        return self._stuck(action, start, types)

    def _narrows(self, class_: str, other: str) -> bool:
        return bool(class_) and (not other or self._ontology.is_a(class_, other))

    def _of_wrong_class(self, action: Action, start: Mapping[str, str], types: Types) -> Reason | None:
        for variable, value in start.items():
            if not self._relaxed.fits(value, types[variable]):
                class_ = types[variable]
                text = Message(
                    "{thing} is not a {kind}, which skill '{skill}' needs",
                    thing=value,
                    kind=local_name(class_),
                    skill=action.skill,
                )
                core = Message(
                    "{thing} is not {kind}: skill '{skill}' can do it with those only",
                    thing=value,
                    kind=some(self._label(class_)),
                    skill=action.skill,
                )
                return Reason(CauseKind.NO_SKILL, text, action.skill, text, (value, class_), core=core)
        missing = (types[v.name] for v in action.parameters if v.name not in start)
        lacking = [class_ for class_ in missing if not self._relaxed.is_some(class_)]
        if not lacking:
            return None
        nowhere = [class_ for class_ in lacking if not self._view.instances(class_)]
        if not nowhere and self._view.instances(ROBOT):  # the task mentions only elements that some skill involves
            text = Message(
                "no skill of the robots that are there has to do with {kind}", kind=some(self._label(lacking[0]))
            )
            return Reason(CauseKind.NO_SKILL, text, action.skill, elements=(lacking[0],))
        class_ = nowhere[0] if nowhere and ROBOT not in nowhere else ROBOT
        return replace(
            self._leaves.none_of(class_),
            skill=action.skill,
            precondition=Message("there is {kind}", kind=some(local_name(class_))),
        )

    def _label(self, class_: str) -> str:
        known = self._ontology.classes.get(class_)
        return local_name(class_) if known is None else known.label

    def _stuck(self, action: Action, start: Mapping[str, str], types: Types) -> _Try:
        pre = self._givens_first(action, start, types)
        ways: Sequence[Mapping[str, str]] = (start,)
        for count, atom in enumerate(pre, start=1):
            further = self._relaxed.ways(action, pre[:count], start, types, _WAYS)
            if not further:
                return _Try(action, start, types, None, tuple(ways), atom, count / (len(pre) + 1))
            ways = further
        return _Try(action, start, types, None, tuple(ways), None, 1.0)

    def _givens_first(self, action: Action, start: Mapping[str, str], types: Types) -> list[Atom]:
        """Orders facts that hold already or never change before those to be achieved; in both groups the rarest first.

        So the reported reason is a fact that could not be achieved for the things at hand. Which agent has the skill
        comes last among the facts that never change: by then the agent is bound; before it what holds for nothing,
        which is then said of the things at hand. Of equals, what is said of the wanted thing comes first: where it is,
        then where the robot is.
        """
        init = self._task.problem.init

        def rank(atom: Atom) -> tuple[bool, bool, bool, int, int, bool]:
            changes = atom.predicate in self._given
            found = self._relaxed.ways(action, [atom], start, types, _WAYS)
            is_given = not changes or (bool(found) and all(atom.bind(way) in init for way in found))
            free = sum(argument not in start for argument in atom.arguments if is_variable(argument))
            is_nowhere = not found and not changes and self._family(atom) is not Family.STRUCTURE
            return not is_given, atom.predicate.startswith(CAN), is_nowhere, len(found), free, changes

        return sorted(action.pre, key=rank)

    # ------------------------------------------------------------ describing it

    def _described(self, one: _Try, chain: Chain) -> Reason:
        if one.stuck is None:
            text = Message("skill '{skill}' could do it for other elements only", skill=one.action.skill)
            return Reason(CauseKind.MISSING_FACT, text, one.action.skill)
        need, found = self._below(one, one.stuck, chain)
        if one.action.skill is None:
            return found
        if need.predicate.startswith(CAN):
            said = {"skill": one.action.skill, "agents": listed(found.elements)}
            core = Message("{agents} do not have the skill '{skill}'", **said)
            if len(found.elements) == 1:
                core = Message("{agents} does not have the skill '{skill}'", **said)
            text = Message("skill '{skill}' would do it, but {reason}", skill=one.action.skill, reason=found.text)
            return replace(found, text=text, core=core)
        words = self._wording.atom(need, one.types)
        said = {"skill": one.action.skill, "need": words, "reason": found.text}
        text = Message("skill '{skill}' would do it, but needs that {need}, and {reason}", **said)
        if need.predicate in self._given and found.skill is not None:
            text = Message("skill '{skill}' would do it, but needs that {need}; {reason}", **said)
        found = replace(found, text=text, core=found.core or found.text)
        return found if found.skill is not None else replace(found, skill=one.action.skill, precondition=words)

    def _below(self, one: _Try, stuck: Atom, chain: Chain) -> tuple[Atom, Reason]:
        """Returns the precondition, bound as precisely as the ways so far allow, and why it never holds."""
        same = {k: v for k, v in one.ways[0].items() if all(way.get(k) == v for way in one.ways)}
        free = stuck.bind({**one.start, **same})
        grounded = list(dict.fromkeys(stuck.bind(way) for way in one.ways))
        if len(grounded) == 1 or len(grounded) > _GROUNDINGS:
            return free, self._why(free, one.types, chain)
        each = [self._why(atom, one.types, chain) for atom in grounded]
        if any(atom != free for atom in grounded) and not self._reached(one, free):
            whole = self._why(free, one.types, chain)
            return free, whole if whole.kind is not CauseKind.FULL else _merged(each)
        return free, _merged(each)

    def _reached(self, one: _Try, atom: Atom) -> bool:
        return bool(self._relaxed.ways(one.action, [atom], one.start, one.types, 1))

    def _why(self, atom: Atom, types: Types, chain: Chain) -> Reason:
        own = {a: types[a] for a in atom.arguments if a in types}
        return self.of(atom, own, chain) if atom.predicate in self._given else self._leaves.of(atom, own)


def _merged(each: Sequence[Reason]) -> Reason:
    """Merges the reasons of several things, none of which is suitable."""
    kind = next(kind for kind in _SPECIFIC if any(one.kind is kind for one in each))
    own = [one for one in each if one.kind is kind]
    elements = tuple(dict.fromkeys(e for one in own for e in one.elements))
    if kind is not CauseKind.FULL:
        return replace(own[0], elements=elements)
    taken = list(dict.fromkeys(one.elements[0] for one in own))
    text = Message("{places} are taken, and no skill takes anything away", places=listed(taken))
    if len(taken) == 1:
        text = Message("{place} is taken, and no skill takes anything away", place=taken[0])
    return replace(own[0], text=text, core=own[0].core if len(taken) == 1 else text, elements=elements)
