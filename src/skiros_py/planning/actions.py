"""Skills as actions (paper §6.2): ``can_<skill>``, variants, implicit deletes over the placement family.

Written for relations in general: which relations move something, and which end moves, is said by the ontology.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count, product

from skiros_py.errors import DescriptionError, PlanningError
from skiros_py.planning.literals import (
    CAN,
    NOTHING,
    Asked,
    Conjunction,
    allows_value,
    asked_literals,
    expand,
    property_of,
)
from skiros_py.planning.model import Action, Atom, Variable
from skiros_py.planning.needs import needs_of, required_elements, sensed_holds_of, with_defaults
from skiros_py.skills.conditions import Assign, Condition, Effect, Not, Relate, Unrelate, effects_of
from skiros_py.skills.inference import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology

__all__ = ["actions_of", "emptiness_classes", "maintain_emptiness", "moved_and_place"]


def actions_of(
    skill: SkillDescription, ontology: Ontology, asked: Mapping[str, Asked | Not] | None = None
) -> tuple[Action, ...]:
    """Translates one skill; one action for each way its preconditions can hold.

    Args:
        skill: The skill.
        ontology: Classes and relations.
        asked: What is asked anywhere in the task about properties, by predicate: what the skill does to that is among
            its effects. The skill's own where left out.

    Raises:
        PlanningError: A condition cannot be said in typed STRIPS; the message names it.
    """
    where = f"skill '{skill.name}'"
    fresh = count(1)
    needed = _said(skill, needs_of(skill))
    choices = [expand(c.pattern, f"{where}, precondition {c}", ontology, fresh) for c in needed]
    variants = list(product(*choices))
    if asked is None:
        asked = asked_literals(c.pattern for c in needed)
    effects = _Effects(skill, ontology, asked)
    names = [skill.name] if len(variants) == 1 else [f"{skill.name}/{i + 1}" for i in range(len(variants))]
    return tuple(_action(n, skill, variant, effects, ontology) for n, variant in zip(names, variants, strict=True))


def _said(skill: SkillDescription, conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """Those conditions that plans know of, over variables and defaults: without what speaks of optional parameters."""
    values = with_defaults(skill, {param.key: param.key for param in required_elements(skill)})
    return tuple(condition.bind(values) for condition in applying(conditions, values))


def _constants(skill: SkillDescription) -> tuple[Variable, ...]:
    """What it takes where nobody says which, with the class it takes that for."""
    defaults = with_defaults(skill, {}).items()
    return tuple(Variable(element, skill.param(key).element_class) for key, element in defaults)


def _action(
    name: str, skill: SkillDescription, pre: Sequence[Conjunction], effects: _Effects, ontology: Ontology
) -> Action:
    own = tuple(Variable(param.key, param.element_class) for param in required_elements(skill))
    extra = tuple(dict.fromkeys(variable for part in pre for variable in part.variables))
    atoms = [Atom(CAN + skill.name, (skill.agent,)), *(atom for part in pre for atom in part.atoms)]
    notes = tuple(f"hold condition {c}: sensed while it runs, unknown to plans" for c in sensed_holds_of(skill))
    needed = tuple(dict.fromkeys(atoms))
    spoken = {argument for atom in (*needed, *effects.add, *effects.delete) for argument in atom.arguments}
    constants = tuple(constant for constant in _constants(skill) if constant.name in spoken)
    draft = Action(name, skill.name, own + extra, needed, effects.add, effects.delete, notes, constants)
    return _with_question_marks(_with_implicit_deletes(draft, ontology))


class _Effects:
    """What a skill's postconditions do to atoms, as lists of atoms that they add and delete."""

    def __init__(self, skill: SkillDescription, ontology: Ontology, asked: Mapping[str, Asked | Not]) -> None:
        self._skill = skill
        self._ontology = ontology
        self._asked = asked
        added: list[Atom] = []
        deleted: list[Atom] = []
        for effect in self._declared():
            add, delete = self._atoms(effect)
            added += add
            deleted += delete
        self.add, self.delete = tuple(added), tuple(deleted)

    def _declared(self) -> list[Effect]:
        try:
            return [effect for condition in _said(self._skill, self._skill.post) for effect in effects_of(condition)]
        except DescriptionError as error:
            raise PlanningError(f"skill '{self._skill.name}', postcondition {error}") from None

    def _atoms(self, effect: Effect) -> tuple[list[Atom], list[Atom]]:
        match effect:
            case Relate(relation, subject, object_):
                return [Atom(relation, (subject, object_))], []
            case Unrelate(relation, subject, object_):
                return [], [Atom(relation, (subject, object_))]
            case Assign(property_, subject, value):
                self._check_no_fallback(effect)
                about = {p: literal for p, literal in self._asked.items() if property_of(literal) == property_}
                true = {p for p, literal in about.items() if allows_value(literal, value)}
                atoms = {p: Atom(p, (subject,)) for p in about}
                return [atoms[p] for p in about if p in true], [atoms[p] for p in about if p not in true]

    def _check_no_fallback(self, effect: Assign) -> None:
        """Refuses to take a value away where that of the class would then count: it differs from class to class."""
        named = {constant.name: constant.type for constant in _constants(self._skill)}
        class_ = named.get(effect.subject) or self._skill.param(effect.subject).element_class
        if effect.value is not None or class_ not in self._ontology.classes:
            return
        given = [
            c for c in self._ontology.subclasses(class_) if self._ontology.class_value(c, effect.property) is not None
        ]
        if given:
            raise PlanningError(
                f"skill '{self._skill.name}' takes away the {effect.property} of {effect.subject}, and the class "
                f"{given[0]} gives one to all its things: set a value instead"
            )


def moved_and_place(atom: Atom, ontology: Ontology) -> tuple[str, str]:
    """Returns the argument that moves and the one that is its place, of an atom of the placement family."""
    subject, object_ = atom.arguments
    at_object = ontology.relations[atom.predicate].place_end == "object"
    return (subject, object_) if at_object else (object_, subject)


def _is_placement(atom: Atom, ontology: Ontology) -> bool:
    return atom.predicate in ontology.relations and ontology.is_placement(atom.predicate)


def _with_implicit_deletes(action: Action, ontology: Ontology) -> Action:
    """Whatever gets a new place loses its old one: named by a precondition, else by a further parameter."""
    for added in action.add:
        if not _is_placement(added, ontology):
            continue
        moved, _ = moved_and_place(added, ontology)
        old = [a for a in action.pre if _is_placement(a, ontology) and moved_and_place(a, ontology)[0] == moved]
        if not old:
            action, fact = _with_old_place(action, added, moved, ontology)
            old = [fact]
        missing = tuple(atom for atom in old if atom not in action.delete)
        note = f"deletes {', '.join(map(_show, missing))}: {moved} has one place only"
        action = replace(action, delete=action.delete + missing, notes=(*action.notes, note))
    return action


def _with_old_place(action: Action, added: Atom, moved: str, ontology: Ontology) -> tuple[Action, Atom]:
    relation = ontology.relations[added.predicate]
    at_object = relation.place_end == "object"
    variable = Variable(f"{moved}_from", (relation.range if at_object else relation.domain) or "")
    arguments = (moved, variable.name) if at_object else (variable.name, moved)
    fact = Atom(added.predicate, arguments)
    note = f"parameter {variable.name} and precondition {_show(fact)}: the place that {moved} leaves"
    parameters = (*action.parameters, variable)
    return replace(action, parameters=parameters, pre=(*action.pre, fact), notes=(*action.notes, note)), fact


def _show(atom: Atom) -> str:
    return f"{atom.predicate.partition(':')[2] or atom.predicate}({', '.join(atom.arguments)})"


def _with_question_marks(action: Action) -> Action:
    names = {v.name: "?" + v.name for v in action.parameters}
    return replace(
        action,
        parameters=tuple(Variable(names[v.name], v.type) for v in action.parameters),
        pre=tuple(a.bind(names) for a in action.pre),
        add=tuple(a.bind(names) for a in action.add),
        delete=tuple(a.bind(names) for a in action.delete),
    )


@dataclass(frozen=True, slots=True)
class _Emptiness:
    """The wish of some precondition that nothing has a relation to a place of this class."""

    relation: str
    class_: str

    @property
    def predicate(self) -> str:
        return NOTHING + self.relation


def emptiness_classes(actions: Iterable[Action]) -> dict[str, str]:
    """Returns the class of place that each "nothing …" precondition asks about.

    Raises:
        PlanningError: Two preconditions ask about different classes.
    """
    classes: dict[str, str] = {}
    for action in actions:
        for atom in action.pre:
            if atom.predicate.startswith(NOTHING):
                class_ = action.types[atom.arguments[0]]
                if classes.setdefault(atom.predicate, class_) != class_:
                    both = f"{classes[atom.predicate]} and {class_}"
                    raise PlanningError(f"'{atom.predicate}' is asked of {both}; use one class of place")
    return classes


def maintain_emptiness(actions: Iterable[Action], ontology: Ontology) -> tuple[Action, ...]:
    """Adds what skills do to "nothing is there": filling ends it, taking the only thing restores it.

    This is sound because every action that fills such a place asks that it be empty before.

    Raises:
        PlanningError: An action fills such a place without asking that it be empty.
    """
    drafts = tuple(actions)
    asked = [_Emptiness(p.removeprefix(NOTHING), c) for p, c in emptiness_classes(drafts).items()]
    for emptiness in asked:
        drafts = tuple(_maintain(action, emptiness, ontology) for action in drafts)
    return drafts


def _maintain(action: Action, emptiness: _Emptiness, ontology: Ontology) -> Action:
    types = action.types
    filled = [a.arguments[1] for a in action.add if a.predicate == emptiness.relation]
    freed = [a.arguments[1] for a in action.delete if a.predicate == emptiness.relation]
    ends = tuple(Atom(emptiness.predicate, (p,)) for p in filled if _overlap(types[p], emptiness.class_, ontology))
    unasked = [atom for atom in ends if atom not in action.pre]
    if unasked:
        raise PlanningError(
            f"skill '{action.skill}' puts something to {unasked[0].arguments[0].lstrip('?')}, which others want empty: "
            f"give it a precondition that nothing is there"
        )
    starts = tuple(Atom(emptiness.predicate, (p,)) for p in freed if ontology.is_a(types[p], emptiness.class_))
    for place in freed:
        if not ontology.is_a(types[place], emptiness.class_) and ontology.is_a(emptiness.class_, types[place]):
            raise PlanningError(
                f"skill '{action.skill}' takes things from any {types[place]}, some of which ({emptiness.class_}) are "
                "asked to be empty: give its parameter a narrower class"
            )
    return replace(action, add=action.add + starts, delete=action.delete + ends)


def _overlap(one: str, other: str, ontology: Ontology) -> bool:
    return ontology.is_a(one, other) or ontology.is_a(other, one)
