"""Skills as actions (paper §6.2): ``can_<skill>``, a variant for each way in which the preconditions can hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import count, product

from skiros_py.errors import DescriptionError, PlanningError
from skiros_py.planning.domain.literals import (
    CAN,
    Asked,
    Conjunction,
    allows_value,
    asked_literals,
    expand,
    property_of,
)
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.needs import needs_of, required_elements, sensed_holds_of, with_defaults
from skiros_py.planning.domain.placing import shown, with_implicit_deletes
from skiros_py.planning.domain.variants import numbered
from skiros_py.skills.conditions import Assign, Condition, Effect, Not, Relate, Unrelate, effects_of
from skiros_py.skills.inference import applying
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import PLACEMENT


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
    where = f"skill '{skill.name}'"
    fresh = count(1)
    needed = _said(skill, needs_of(skill))
    choices = [expand(c.pattern, f"{where}, precondition {c}", ontology, fresh) for c in needed]
    if asked is None:
        asked = asked_literals((c.pattern for c in needed), ontology)
    effects = _Effects(skill, ontology, asked)
    variants = [_action(skill, variant, effects, _chosen(needed, choices, variant)) for variant in product(*choices)]
    complete = (action for variant in variants for action in with_implicit_deletes(variant, ontology))
    return numbered(map(_with_question_marks, complete))


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


def _action(skill: SkillDescription, pre: Sequence[Conjunction], effects: _Effects, notes: tuple[str, ...]) -> Action:
    own = tuple(Variable(param.key, param.element_class) for param in required_elements(skill))
    extra = tuple(dict.fromkeys(variable for part in pre for variable in part.variables))
    able = Atom(CAN + skill.name, (skill.agent,))
    needed = tuple(dict.fromkeys([able, *(atom for part in pre for atom in part.atoms)]))
    none = tuple(dict.fromkeys(none for part in pre for none in part.none))
    of_one = [c for c in skill.needs if c not in skill.described and c not in skill.pre]
    spoken = {a for atom in (*needed, *effects.add, *effects.delete) for a in atom.arguments}
    spoken |= {a for such in none for atom in such.atoms for a in atom.arguments}
    said = (
        f"precondition {shown(able)}: who has the skill",
        *(f"precondition {c}: its devices are of one robot" for c in of_one),
        *(f"precondition {c}: what its parameter is described as" for c in skill.described),
        *notes,
        *(f"hold condition {c} left out: sensed while it runs, unknown to plans" for c in sensed_holds_of(skill)),
    )
    constants = tuple(constant for constant in _constants(skill) if constant.name in spoken)
    return Action(skill.name, skill.name, own + extra, needed, effects.add, effects.delete, said, constants, none)


class _Effects:
    """The effects of a skill's postconditions, as lists of added and deleted atoms."""

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
                self._check_storable(relation)
                return [Atom(relation, (subject, object_))], []
            case Unrelate(relation, subject, object_):
                below = self._ontology.sub_relations(relation)
                return [], [Atom(r, (subject, object_)) for r in below if r != PLACEMENT]
            case Assign(property_, subject, value):
                self._check_no_fallback(effect)
                about = {p: literal for p, literal in self._asked.items() if property_of(literal) == property_}
                true = {p for p, literal in about.items() if allows_value(literal, value)}
                atoms = {p: Atom(p, (subject,)) for p in about}
                return [atoms[p] for p in about if p in true], [atoms[p] for p in about if p not in true]

    def _check_storable(self, relation: str) -> None:
        if relation == PLACEMENT:
            below = ", ".join(r for r in self._ontology.sub_relations(relation) if r != relation)
            raise PlanningError(
                f"skill '{self._skill.name}' has a postcondition of {relation}, which says that something is somewhere "
                f"but not how: use one of {below}"
            )

    def _check_no_fallback(self, effect: Assign) -> None:
        """Refuses to remove a value if the class's value would then apply: it differs from class to class."""
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


def _with_question_marks(action: Action) -> Action:
    names = {v.name: "?" + v.name for v in action.variables}
    return replace(
        action,
        parameters=_renamed(action.parameters, names),
        pre=tuple(a.bind(names) for a in action.pre),
        add=tuple(a.bind(names) for a in action.add),
        delete=tuple(a.bind(names) for a in action.delete),
        none=tuple(NoneSuch(_renamed(n.variables, names), tuple(a.bind(names) for a in n.atoms)) for n in action.none),
    )


def _renamed(variables: Iterable[Variable], names: Mapping[str, str]) -> tuple[Variable, ...]:
    return tuple(Variable(names[v.name], v.type) for v in variables)
