"""Skills as actions (paper §6.2): ``can_<skill>``, a variant for each way in which the preconditions can hold.

The same applies to functional relations that get another object. Works for relations in general: the ontology defines
which of them move something, and which end moves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from itertools import count, product

from skiros_py.errors import DescriptionError, PlanningError
from skiros_py.planning.domain.literals import (
    CAN,
    IS,
    Asked,
    Conjunction,
    allows_value,
    asked_literals,
    expand,
    property_of,
    storable,
)
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.numbers import change_atom, could_become_true
from skiros_py.skills.conditions import Condition, Not
from skiros_py.skills.conditions.effects import Assign, Relate, Unrelate, effects_of
from skiros_py.skills.conditions.expression import is_sensed
from skiros_py.skills.conditions.pattern import NumberChange
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT


def needs_of(skill: SkillDescription) -> tuple[Condition, ...]:
    """Returns the conditions a plan must ensure: preconditions, and hold conditions except sensed ones."""
    return (*skill.needs, *(c for c in skill.hold if not is_sensed(c.pattern)))


def required_elements(skill: SkillDescription) -> tuple[Param, ...]:
    """Returns the element parameters that a plan must bind; the others have a default or stay open.

    Agent and target are always included.
    """
    ends = (skill.agent, skill.target)
    return tuple(p for p in skill.params if p.is_element and (p.kind.is_required or p.key in ends))


def passed_keys(skill: SkillDescription) -> tuple[str, ...]:
    """Returns the keys that a plan passes: agent, target, and those in the author's conditions.

    The others are inferred when the skill starts, by the author's preferences.
    """
    said = (*skill.described, *skill.pre, *skill.hold, *skill.post)
    spoken = {skill.agent, skill.target, *(key for condition in said for key in condition.arguments)}
    return tuple(param.key for param in required_elements(skill) if param.key in spoken)


def with_defaults(skill: SkillDescription, arguments: Mapping[str, str]) -> dict[str, str]:
    """Returns the arguments of a call, completed with the skill's default elements."""
    elements = (param for param in skill.params if param.is_element and param.default is not None)
    return {param.key: param.default for param in elements} | dict(arguments)


def moved_and_place(atom: Atom, ontology: Ontology) -> tuple[str, str]:
    """Returns the argument that moves and the one that is its place, of an atom of the placement family."""
    subject, object_ = atom.arguments
    at_object = ontology.relations[atom.predicate].place_end == "object"
    return (subject, object_) if at_object else (object_, subject)


def is_placement(atom: Atom, ontology: Ontology) -> bool:
    """Returns whether an atom says where something is."""
    return atom.predicate in ontology.relations and ontology.is_placement(atom.predicate)


def with_implicit_deletes(action: Action, ontology: Ontology) -> tuple[Action, ...]:
    """Makes moved things leave their old place: named by a precondition, else by an additional parameter.

    Returns:
        The action; if no precondition gives the relation to the old place, a variant for each possible relation, the
        one to the new place first.
    """
    variants: tuple[Action, ...] = (action,)
    for added in action.add:
        if is_placement(added, ontology):
            variants = tuple(v for variant in variants for v in _leaving(variant, added, ontology))
        elif added.predicate in ontology.relations and ontology.relations[added.predicate].functional:
            variants = tuple(v for variant in variants for v in _replacing(variant, added, ontology))
    return variants


def _replacing(action: Action, added: Atom, ontology: Ontology) -> tuple[Action, ...]:
    """Creates the variant in which the relation had another object before, and the one in which it had none."""
    subject, new = added.arguments
    old = tuple(a for a in action.pre if a.predicate == added.predicate and a.arguments[0] == subject)
    if old:
        return (_without(action, old, f"{subject} has one such thing only"),)
    variable = Variable(_unused(f"{new}_before", action), ontology.relations[added.predicate].range or "")
    fact = Atom(added.predicate, (subject, variable.name))
    had = _with_old(action, variable, fact, f"what {subject} has had until then")
    none = NoneSuch((replace(variable, type=variable.type or ELEMENT),), (fact,))
    note = f"precondition no {shown(fact)}: the other variant is for when there is one"
    return (
        _without(had, (fact,), f"{subject} has one such thing only"),
        replace(action, none=(*action.none, none), notes=(*action.notes, note)),
    )


def _with_old(action: Action, variable: Variable, fact: Atom, what: str) -> Action:
    """Adds the parameter and the precondition for what an action ends."""
    note = f"parameter {variable.name}, precondition {shown(fact)}: {what}"
    parameters = (*action.parameters, variable)
    return replace(action, parameters=parameters, pre=(*action.pre, fact), notes=(*action.notes, note))


def _leaving(action: Action, added: Atom, ontology: Ontology) -> tuple[Action, ...]:
    moved, _ = moved_and_place(added, ontology)
    old = tuple(a for a in action.pre if is_placement(a, ontology) and moved_and_place(a, ontology)[0] == moved)
    if old:
        return (_without(action, old, f"{moved} has one place only"),)
    relations = _possible(action.types[moved], added.predicate, ontology)
    variants = (_with_old_place(action, relation, moved, ontology) for relation in relations)
    return tuple(_without(variant, variant.pre[-1:], f"{moved} has one place only") for variant in variants)


def _without(action: Action, old: tuple[Atom, ...], why: str) -> Action:
    missing = tuple(atom for atom in old if atom not in action.delete)
    if not missing:
        return action
    note = f"effect not {', not '.join(map(shown, missing))}: {why}"
    return replace(action, delete=action.delete + missing, notes=(*action.notes, note))


def _possible(class_: str, first: str, ontology: Ontology) -> tuple[str, ...]:
    """Returns the placement relations that something of a class can have, a given one first."""

    def can_be_moved(relation: str) -> bool:
        words = ontology.relations[relation]
        end = words.domains if words.place_end == "object" else words.ranges
        below = ontology.subclasses(class_) if class_ in ontology.classes else ()
        return not below or any(not ontology.missed_end(kind, end) for kind in below)

    return (first, *(r for r in storable(PLACEMENT, ontology) if r != first and can_be_moved(r)))


def _with_old_place(action: Action, relation: str, moved: str, ontology: Ontology) -> Action:
    words = ontology.relations[relation]
    at_object = words.place_end == "object"
    variable = Variable(_unused(f"{moved}_from", action), (words.range if at_object else words.domain) or "")
    fact = Atom(relation, (moved, variable.name) if at_object else (variable.name, moved))
    return _with_old(action, variable, fact, f"the place that {moved} leaves")


def _unused(name: str, action: Action) -> str:
    """Returns a name that no parameter has, as close to the given one as possible."""
    while name in action.types:
        name += "'"
    return name


def shown(atom: Atom) -> str:
    """Returns an atom in readable form: "in(Ball, Box)"."""
    words = atom.predicate.split(" ")
    named = " ".join(word.partition(":")[2] or word for word in words)
    return f"{named}({', '.join(argument.lstrip('?') for argument in atom.arguments)})"


def numbered(actions: Iterable[Action]) -> tuple[Action, ...]:
    """Names each action after its skill, with a number where there are several of one; bookkeeping keeps its names."""
    drafts = tuple(actions)
    count = Counter(action.skill for action in drafts)
    reached: Counter[str | None] = Counter()
    result = []
    for action in drafts:
        reached[action.skill] += 1
        name = action.skill if count[action.skill] == 1 else f"{action.skill}/{reached[action.skill]}"
        result.append(action if action.skill is None or name is None else replace(action, name=name))
    return tuple(result)


def possible_variants(actions: Iterable[Action], view: WorldView) -> tuple[Action, ...]:
    """Removes variants with a placement that nothing of the class has or can ever get.

    If no variant is possible, a skill's first one is kept, so that explanations can name what it lacks.
    """
    drafts, ontology = tuple(actions), view.ontology
    brought: dict[str, set[str]] = {}
    for action in drafts:
        for moved, atom in _moved(action, action.add, ontology):
            brought.setdefault(atom.predicate, set()).add(moved)

    @cache
    def may_be(class_: str, relation: str) -> bool:
        if any(ontology.overlap(class_, other) for other in brought.get(relation, ())):
            return True
        return view.any_placed(class_, relation)

    possible = [a for a in drafts if all(may_be(m, p.predicate) for m, p in _moved(a, a.pre, ontology))]
    there = {action.skill for action in possible}
    kept: list[Action] = []
    for action in drafts:
        if action in possible or action.skill not in there:
            kept.append(action)
            there.add(action.skill)
    return numbered(kept)


def _moved(action: Action, atoms: Iterable[Atom], ontology: Ontology) -> Iterator[tuple[str, Atom]]:
    """Yields the placements among atoms, with the class of what is placed."""
    types = action.types
    for atom in atoms:
        if is_placement(atom, ontology):
            class_ = types[moved_and_place(atom, ontology)[0]]
            if class_ in ontology.classes:
                yield class_, atom


def actions_of(
    skill: SkillDescription, ontology: Ontology, asked: Mapping[str, Asked | Not] | None = None
) -> tuple[Action, ...]:
    """Translates one skill; one action for each way its preconditions can hold.

    Args:
        skill: The skill.
        ontology: Classes and relations.
        asked: All property conditions in the task, by predicate: the skill's changes to them become effects. By
            default, the skill's own.

    Raises:
        PlanningError: A condition cannot be expressed in typed STRIPS; the message names it.
    """
    return _translated(skill, ontology, None if asked is None else tuple(asked.items()))


@lru_cache(maxsize=64)
def _translated(
    skill: SkillDescription, ontology: Ontology, literals: tuple[tuple[str, Asked | Not], ...] | None
) -> tuple[Action, ...]:
    where = f"skill '{skill.name}'"
    fresh = count(1)
    needed = _said(skill, needs_of(skill))
    choices = [expand(c.pattern, f"{where}, precondition {c}", ontology, fresh) for c in needed]
    asked = asked_literals((c.pattern for c in needed), ontology) if literals is None else dict(literals)
    effects = _effects(skill, ontology, asked)
    variants = [
        _action(skill, variant, effects, asked, _chosen(needed, choices, variant)) for variant in product(*choices)
    ]
    narrow = (_narrowed(variant, ontology) for variant in variants)
    complete = (action for variant in narrow for action in with_implicit_deletes(variant, ontology))
    return numbered(map(_with_question_marks, complete))


def _narrowed(action: Action, ontology: Ontology) -> Action:
    """Gives parameters the narrower classes that preconditions ask of them, instead of those preconditions."""
    classes = {parameter.name: parameter.type for parameter in action.parameters}
    pre = []
    for atom in action.pre:
        class_, name = atom.predicate.removeprefix(IS), atom.arguments[0]
        if atom.predicate.startswith(IS) and name in classes and ontology.is_a(class_, classes[name]):
            classes[name] = class_
        else:
            pre.append(atom)
    parameters = tuple(replace(one, type=classes[one.name]) for one in action.parameters)
    return replace(action, parameters=parameters, pre=tuple(pre))


def _chosen(
    conditions: Sequence[Condition], choices: Sequence[Sequence[Conjunction]], variant: Sequence[Conjunction]
) -> tuple[str, ...]:
    """Describes which alternative of a condition a variant stands for."""
    several = (
        (condition, ways.index(way) + 1, way)
        for condition, ways, way in zip(conditions, choices, variant, strict=True)
        if len(ways) > 1
    )
    return tuple(f"variant: way {n} of {c}: {', '.join(map(shown, way.atoms))}" for c, n, way in several)


def _said(skill: SkillDescription, conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """The conditions that planning uses, over variables and defaults: without those on optional parameters."""
    values = with_defaults(skill, {param.key: param.key for param in required_elements(skill)})
    return tuple(condition.bind(values) for condition in applying(conditions, values))


def _constants(skill: SkillDescription) -> tuple[Variable, ...]:
    """The default elements of a skill's parameters, with their classes."""
    defaults = with_defaults(skill, {}).items()
    return tuple(Variable(element, skill.param(key).element_class) for key, element in defaults)


def _action(
    skill: SkillDescription,
    pre: Sequence[Conjunction],
    effects: _Effects,
    asked: Iterable[str],
    notes: tuple[str, ...],
) -> Action:
    add, delete, changes = effects
    own = tuple(Variable(param.key, param.element_class) for param in required_elements(skill))
    extra = tuple(dict.fromkeys(variable for part in pre for variable in part.variables))
    able = Atom(CAN + skill.name, (skill.agent,))
    needed = tuple(dict.fromkeys([able, *(atom for part in pre for atom in part.atoms)]))
    add = (*add, *could_become_true(changes, needed, asked))
    none = tuple(dict.fromkeys(none for part in pre for none in part.none))
    of_one = [c for c in skill.needs if c not in (*skill.counted, *skill.described, *skill.pre)]
    sensed = [c for c in skill.hold if is_sensed(c.pattern)]
    spoken = {a for atom in (*needed, *add, *delete) for a in atom.arguments}
    spoken |= {a for such in none for atom in such.atoms for a in atom.arguments}
    said = (
        f"precondition {shown(able)}: who has the skill",
        *(f"precondition {c}: its devices are of one robot" for c in of_one),
        *(f"precondition {c}: what its parameter is described as" for c in skill.described),
        *notes,
        *(f"precondition {c}: a number that is missing cannot be changed" for c in skill.counted),
        *(f"hold condition {c} left out: sensed while it runs, unknown to plans" for c in sensed),
    )
    constants = tuple(constant for constant in _constants(skill) if constant.name in spoken)
    parameters = own + extra
    return Action(skill.name, skill.name, parameters, needed, add, delete, said, constants, none, changes=changes)


_Effects = tuple[tuple[Atom, ...], tuple[Atom, ...], tuple[Atom, ...]]


def _effects(skill: SkillDescription, ontology: Ontology, asked: Mapping[str, Asked | Not]) -> _Effects:
    """Returns the atoms that a skill's postconditions add and delete, and what they do to numbers."""
    try:
        effects = [effect for condition in _said(skill, skill.post) for effect in effects_of(condition)]
    except DescriptionError as error:
        raise PlanningError(f"skill '{skill.name}', postcondition {error}") from None
    added: list[Atom] = []
    deleted: list[Atom] = []
    changes: list[Atom] = []
    for effect in effects:
        match effect:
            case Relate(relation, subject, object_):
                _check_storable(relation, skill, ontology)
                added.append(Atom(relation, (subject, object_)))
            case Unrelate(relation, subject, object_):
                below = (r for r in ontology.sub_relations(relation) if r != PLACEMENT)
                deleted += [Atom(r, (subject, object_)) for r in below]
            case Assign(property_, subject, value):
                _check_no_fallback(effect, skill, ontology)
                for predicate, literal in asked.items():
                    if property_of(literal) == property_:
                        atoms = added if allows_value(literal, value) else deleted
                        atoms.append(Atom(predicate, (subject,)))
        if isinstance(effect, Assign | NumberChange):
            changes += filter(None, (change_atom(effect),))
    return tuple(added), tuple(deleted), tuple(changes)


def _check_storable(relation: str, skill: SkillDescription, ontology: Ontology) -> None:
    if relation == PLACEMENT:
        below = ", ".join(r for r in ontology.sub_relations(relation) if r != relation)
        raise PlanningError(
            f"skill '{skill.name}' has a postcondition of {relation}, which says that something is somewhere "
            f"but not how: use one of {below}"
        )


def _check_no_fallback(effect: Assign, skill: SkillDescription, ontology: Ontology) -> None:
    """Refuses to remove a value if the class's value would then apply: it differs from class to class."""
    named = {constant.name: constant.type for constant in _constants(skill)}
    class_ = named.get(effect.subject) or skill.param(effect.subject).element_class
    if effect.value is not None or class_ not in ontology.classes:
        return
    given = [c for c in ontology.subclasses(class_) if ontology.class_value(c, effect.property) is not None]
    if given:
        raise PlanningError(
            f"skill '{skill.name}' takes away the {effect.property} of {effect.subject}, and the class "
            f"{given[0]} gives one to all its things: set a value instead"
        )


def _with_question_marks(action: Action) -> Action:
    names = {v.name: "?" + v.name for v in action.variables}
    return replace(
        action,
        parameters=_renamed(action.parameters, names),
        pre=tuple(a.bind(names) for a in action.pre),
        add=tuple(a.bind(names) for a in action.add),
        delete=tuple(a.bind(names) for a in action.delete),
        changes=tuple(a.bind(names) for a in action.changes),
        none=tuple(NoneSuch(_renamed(n.variables, names), tuple(a.bind(names) for a in n.atoms)) for n in action.none),
    )


def _renamed(variables: Iterable[Variable], names: Mapping[str, str]) -> tuple[Variable, ...]:
    return tuple(Variable(names[v.name], v.type) for v in variables)
