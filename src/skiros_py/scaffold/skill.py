"""Writes a skill: its description with preconditions and effects, and its real or pretended implementation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

from skiros_py.authoring import skill_name
from skiros_py.errors import DescriptionError, PlanningError, UnknownName, UsageError
from skiros_py.planning.domain.literals import expand
from skiros_py.scaffold.declared import joined, kind_of, module_name, read_parameter, snake_case, words_of
from skiros_py.scaffold.draft import Draft, listed, literal, render
from skiros_py.scaffold.orders import NewSkill
from skiros_py.scaffold.primitive import check_keys, declarations
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.stage import Stage, open_questions
from skiros_py.skills.conditions import Condition, Not, Related
from skiros_py.skills.conditions.effects import effects_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.parameters.values import SAMPLES
from skiros_py.world.names import local_name

_HAS_PART = "HasPart"
_ROBOT = "robot"


@dataclass(frozen=True, slots=True)
class Described:
    """A skill's description: its parameters, the agent first, and its conditions."""

    agent: str
    target: str
    params: tuple[Param, ...]
    pre: tuple[Condition, ...]
    post: tuple[Condition, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its conditions, each once."""
        return tuple(dict.fromkeys(condition.type.name for condition in (*self.pre, *self.post)))


def described(known: Knowledge, said: NewSkill) -> Described:
    """Creates a description from the author's options; keys are spelt as Python spells attributes ("Part": "part").

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    skill = f"skill '{said.name}'"
    own = [replace(p, key=snake_case(p.key)) for p in (read_parameter(text, known.ontology) for text in said.params)]
    check_keys(own, skill)
    agent = _agent(known, said, own)
    params = [agent, *(param for param in own if param.key != agent.key)]
    pre, post = ([_spelt(known.read_condition(text, skill)) for text in texts] for texts in (said.pre, said.post))
    if not post:
        raise UsageError(f"{skill}: give a --post, such as 'Scanned(Part)': what it brings about")
    params += _missing_devices(known, said, params)
    params, implied = _with_robot(known, params, [*pre, *post])
    for condition in (*implied, *pre, *post):
        _check_arguments(known, condition, params, skill)
    for condition in post:
        try:
            effects_of(condition)
        except DescriptionError as error:
            raise UsageError(f"{skill}, --post {condition}: {error}") from error
    return Described(agent.key, _target(said, params, post), tuple(params), (*implied, *pre), tuple(post))


def _spelt(condition: Condition) -> Condition:
    return replace(condition, arguments=tuple(map(snake_case, condition.arguments)))


def _agent(known: Knowledge, said: NewSkill, own: Sequence[Param]) -> Param:
    """Returns the parameter for the executing subsystem: one declared by the author, else a new one."""
    if not said.agent:
        raise UsageError(f"skill '{said.name}': give --agent CLASS, such as sk:Arm: the subsystem that does it")
    class_ = known.ontology.resolve_class(said.agent)
    if not known.ontology.is_a(class_, "sk:Agent"):
        agents = ", ".join(known.ontology.subclasses("sk:Agent"))
        raise UsageError(f"skill '{said.name}': --agent {class_} has no skill manager; there is {agents}")
    key = snake_case(local_name(class_))
    help_ = f"The {words_of(key)} that does it."
    return next((p for p in own if p.type == class_), Param(key, class_, help_, Kind.HARDWARE))


def _missing_devices(known: Knowledge, said: NewSkill, params: Sequence[Param]) -> Iterator[Param]:
    """Yields parameters for the devices that its primitives need and that are not declared."""
    there = [param.element_class for param in params if param.is_element]
    for param in (param for primitive in said.do for param in known.primitive(primitive)):
        type_ = param.type_name
        if param.kind is Kind.HARDWARE and not any(known.ontology.is_a(own, type_) for own in there):
            there.append(type_)
            yield Param(snake_case(local_name(type_)), type_, param.help, kind_of(type_, known.ontology))


def _with_robot(
    known: Knowledge, params: Sequence[Param], conditions: Sequence[Condition]
) -> tuple[list[Param], list[Condition]]:
    """Adds the robot that has the devices, and the relations to them, unless the author specifies the relations."""
    if _HAS_PART not in known.catalogue.conditions:
        return list(params), []

    def first(class_: str) -> str | None:
        return next((p.key for p in params if p.is_element and known.ontology.is_a(p.element_class, class_)), None)

    said = {argument for one in conditions if one.type.name == _HAS_PART for argument in one.arguments[1:]}
    devices = [p for p in params if p.kind is Kind.HARDWARE and p.key not in said]
    robot = first("sk:Robot")
    named = any(_ROBOT in one.arguments for one in conditions)
    if not devices and (robot or not named):
        return list(params), []
    if robot is None:
        robot = _ROBOT
        params = [params[0], Param(robot, "sk:Robot", "The robot that has it.", Kind.PLANNING), *params[1:]]
    arm = first("sk:Arm") or robot
    bodies = [p for p in devices if p.key == arm or known.ontology.is_a(p.element_class, "sk:Base")]
    bodies += [p for p in devices if known.ontology.is_a(p.element_class, "sk:Arm")]
    has_part = known.condition(_HAS_PART)
    return list(params), [has_part(robot if p in bodies else arm, p.key) for p in devices]


def _check_arguments(known: Knowledge, condition: Condition, params: Sequence[Param], skill: str) -> None:
    keys = {param.key: param for param in params}
    for role, argument in zip(condition.type.roles, condition.arguments, strict=True):
        if argument not in keys:
            raise UnknownName("parameter", argument, keys, where=f"in {condition} of {skill}")
        param = keys[argument]
        if not param.is_element or not known.ontology.is_a(param.element_class, role.class_):
            raise UsageError(f"{condition}: {argument} is a {param.type}; it must be a {role.class_} there")


def _target(said: NewSkill, params: Sequence[Param], post: Sequence[Condition]) -> str:
    keys = [param.key for param in params]
    if target := snake_case(said.target):
        if target not in keys:
            raise UnknownName("parameter", target, keys, where=f"as --target of skill '{said.name}'")
        return target
    spoken_of = [argument for one in post for argument in one.arguments]
    things = [param.key for param in params if param.is_element and param.kind is Kind.ONLINE]
    return next((key for key in things if key in spoken_of), (*things, *spoken_of)[0])


def draft_skill(known: Knowledge, said: NewSkill) -> Draft:
    """Writes a skill, composed of primitives or with a body of its own; and its test.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "skill")
    known.check_free("skill", name)
    package, class_ = known.project.package, joined(name)
    values = known.project.names("skills", name, name, said.help or words_of(name), class_name=class_)
    skill = described(known, said)
    origins = {word: known.origin("skiros.conditions", word) for word in skill.words}
    calls = calls_of(known, said.do, skill.params)
    stage = Stage(known, name, said.robot)
    cast = _staged(known, said, skill, stage)

    def written(conditions: Sequence[Condition]) -> list[str]:
        return [
            f"{'~' * one.negated}{origins[one.type.name].attribute}({', '.join(map(literal, one.arguments))})"
            for one in conditions
        ]

    is_own = {(o.module, o.attribute): o.module.partition(".")[0] == package for o in origins.values()}
    texts = (
        render(
            "skill.py",
            **values,
            calls=calls,
            foreign=[pair for pair, own in is_own.items() if not own],
            own=[pair for pair, own in is_own.items() if own],
            is_named=skill_name(class_) != name,
            agent=skill.agent,
            target=skill.target,
            **declarations(skill.params),
            conditions=[(key, written(some)) for key, some in (("pre", skill.pre), ("post", skill.post)) if some],
        ),
        render(
            "skill_test.py", **values, skills=_helpers(known, name, skill), **_trial(known, said, skill, stage, cast)
        ),
        stage.turtle(f"What is needed to {words_of(name)}."),
    )
    notes = [
        f"tests/skills/scenes/{name}.ttl does not make it true: {why}; see to it by hand"
        for why in open_questions(stage, skill.pre, cast)
    ]
    needs = [origin.distribution.name for origin in origins.values()]
    return known.project.module_draft("skills", name, {name: class_}, texts, needs, notes)


def _staged(known: Knowledge, said: NewSkill, skill: Described, stage: Stage) -> Mapping[str, str]:
    """Prepares a scene in which it can be executed, with its effects as the goal; returns its individuals."""
    cast = {param.key: stage.cast(param.element_class, param.key) for param in skill.params if param.is_element}
    for condition in skill.pre:
        stage.suppose(condition.pattern, cast)
    stage.goals += [str(condition.bind(cast)) for condition in skill.post if _is_plannable(known, condition)]
    if not stage.goals:
        raise UsageError(
            f"skill '{said.name}': its first goal cannot be what is not so; give a --post of what is so then"
        )
    return cast


def _is_plannable(known: Knowledge, condition: Condition) -> bool:
    """Returns whether it is suitable as a first goal: the absence of a relation is a poor one."""
    if isinstance(condition.pattern, Not) and isinstance(condition.pattern.pattern, Related):
        return False
    try:
        expand(condition.pattern, str(condition), known.ontology, count(1))
    except PlanningError:
        return False
    return True


def _helpers(known: Knowledge, name: str, skill: Described) -> str:
    """Returns the skills of its test: itself, and what brings about its preconditions, but not its effects."""
    effects, wanted = ({one.type.name for one in some} for some in (skill.post, skill.pre))
    found: dict[str, None] = {}
    others = [other.description for other in known.catalogue.skills.values()]
    others = [one for one in others if effects.isdisjoint(condition.type.name for condition in one.post)]
    while more := [o for o in others if o.name not in found and wanted & {condition.type.name for condition in o.post}]:
        found |= dict.fromkeys(one.name for one in more)
        wanted |= {condition.type.name for one in more for condition in one.pre}
    return listed([literal(one) for one in sorted({name, *found})], "skills=", 8, ",")


def _trial(known: Knowledge, said: NewSkill, skill: Described, stage: Stage, cast: Mapping[str, str]) -> dict[str, Any]:
    """Returns the data of the test: the arguments of a trial if all primitives are the package's own.

    Foreign primitives may need real arms.
    """
    package = known.project.package
    origins = [known.origin("skiros.primitives", name) for name in dict.fromkeys(said.do)]
    if any(o.module.partition(".")[0] != package for o in origins):
        return {"own": []}
    given = [(p.key, cast.get(p.key, SAMPLES.get(p.type_name))) for p in skill.params if p.kind is Kind.ONLINE]
    own = [(f"{package}.skills.{said.name}", joined(said.name)), *((o.module, o.attribute) for o in origins)]
    return {
        "own": own,
        "primitives": [f"primitives=[{', '.join(origin.attribute for origin in origins)}]"] if origins else [],
        "places": [list(map(literal, place)) for place in stage.left_to_robot],
        "arguments": [f"{key}={literal(value)}" for key, value in given],
    }


# ---------------------------------------------------------------- how its body calls primitives


def calls_of(known: Knowledge, primitives: Sequence[str], params: Sequence[Param]) -> list[list[str]]:
    """Returns the arguments of one ``Do.of`` per primitive.

    A parameter of a primitive gets the skill's of the same name, whatever its capitals, else the only one of a class
    that fits.

    Raises:
        UnknownName: There is no such primitive.
        UsageError: Nothing fits a parameter that must be given, or several do.
    """
    return [[literal(name), *_arguments(known, name, params)] for name in primitives]


def _arguments(known: Knowledge, primitive: str, params: Sequence[Param]) -> Iterator[str]:
    for param in known.primitive(primitive):
        able = [p for p in params if _fits(known, p, param)]
        named = [p for p in able if p.key.casefold() == param.key.casefold()]
        found = named or (able if param.is_element else [])
        if len(found) == 1:
            yield f"{param.key}=P({literal(found[0].key)})"
        elif param.kind.is_required:
            fit = f"{', '.join(p.key for p in found)} all fit" if found else "no parameter of the skill fits"
            raise UsageError(
                f"--do {primitive}: it needs {param.key} ({param.type}: {param.help}), and {fit}; declare --param"
                f" {param.key}:{param.type}"
            )


def _fits(known: Knowledge, own: Param, param: Param) -> bool:
    if own.is_element and param.is_element:
        return known.ontology.is_a(own.element_class, param.element_class)
    return own.type == param.type
