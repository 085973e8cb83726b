"""Writes a skill: its description with preconditions and effects, and its real or pretended implementation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

from skiros_py.errors import DescriptionError, PlanningError, UnknownName, UsageError
from skiros_py.planning.domain.literals import expand
from skiros_py.scaffold.declared import (
    Declared,
    Wanted,
    check_distinct,
    constant_name,
    kind_of,
    module_name,
    read_parameter,
    read_wanted,
    sentence,
    words_of,
)
from skiros_py.scaffold.draft import Draft, literal, render
from skiros_py.scaffold.primitive import SAMPLES, check_keys
from skiros_py.scaffold.project import Knowledge, Project
from skiros_py.scaffold.robot import find_robot
from skiros_py.scaffold.stage import Stage, open_questions, tried
from skiros_py.skills.conditions import Condition, Not, Related, effects_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.world.names import local_name

_HAS_PART = "HasPart"
_ROBOT = "Robot"


@dataclass(frozen=True, slots=True)
class NewSkill:
    """The author's options for a skill.

    Attributes:
        name: Its name ("scan").
        help: One sentence; derived from the name if omitted.
        agent: Class of the subsystem that executes it ("sk:Arm"). It adds a parameter for the subsystem and, if the
            condition for it is installed, one for its robot and the condition that it is part of the robot.
        params: Its other parameters (``Part:sk:Manipulatable``).
        pre, post: Conditions over the parameters (``Scanned(Part)``).
        do: Primitives that implement it, in order; none for a skill that is only pretended.
        target: Key of the parameter to which it is applied; if omitted, the first one in a postcondition.
        robot: Name of the robot in its test.
    """

    name: str
    help: str = ""
    agent: str = ""
    params: tuple[str, ...] = ()
    pre: tuple[str, ...] = ()
    post: tuple[str, ...] = ()
    do: tuple[str, ...] = ()
    target: str = ""
    robot: str = "mobile_panda"


@dataclass(frozen=True, slots=True)
class Described:
    """A skill's description: its parameters, the agent first, and its conditions as they are written and meant."""

    agent: str
    target: str
    params: tuple[Declared, ...]
    pre: tuple[tuple[Wanted, Condition], ...]
    post: tuple[tuple[Wanted, Condition], ...]

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its conditions, each once."""
        return tuple(dict.fromkeys(wanted.word for wanted, _ in (*self.pre, *self.post)))


def described(known: Knowledge, said: NewSkill) -> Described:
    """Creates a description from the author's options.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    own = [read_parameter(text, known.ontology) for text in said.params]
    agent = _agent(known, said, own)
    params = [agent, *(param for param in own if param.key != agent.key)]
    check_keys(own, f"skill '{said.name}'")
    pre, post = ([read_wanted(text) for text in texts] for texts in (said.pre, said.post))
    if not post:
        raise UsageError(f"skill '{said.name}': give a --post, such as 'Scanned(Part)': what it brings about")
    params += _missing_devices(known, said, params)
    params, implied = _with_robot(known, params, [*pre, *post])
    meant = [[(one, _meant(known, said, one, params)) for one in some] for some in ([*implied, *pre], post)]
    for wanted, condition in meant[1]:
        _check_effect(said, wanted, condition)
    return Described(agent.key, _target(said, params, post), tuple(params), tuple(meant[0]), tuple(meant[1]))


def _agent(known: Knowledge, said: NewSkill, own: Sequence[Declared]) -> Declared:
    """Returns the parameter for the executing subsystem: one declared by the author, else a new one."""
    if not said.agent:
        raise UsageError(f"skill '{said.name}': give --agent CLASS, such as sk:Arm: the subsystem that does it")
    class_ = known.ontology.resolve_class(said.agent)
    if not known.ontology.is_a(class_, "sk:Agent"):
        agents = ", ".join(known.ontology.subclasses("sk:Agent"))
        raise UsageError(f"skill '{said.name}': --agent {class_} has no skill manager; there is {agents}")
    key = local_name(class_)
    help_ = f"The {words_of(key)} that does it."
    return next((p for p in own if p.type == class_), Declared(key, class_, help_, Kind.HARDWARE))


def _missing_devices(known: Knowledge, said: NewSkill, params: Sequence[Declared]) -> Iterator[Declared]:
    """Yields parameters for the devices that its primitives need and that are not declared."""
    there = [param.type for param in params if param.is_element]
    for primitive in said.do:
        for param in known.primitive(primitive):
            type_ = param.type
            if param.kind is not Kind.HARDWARE or not isinstance(type_, str):
                continue
            if not any(known.ontology.is_a(own, type_) for own in there):
                there.append(type_)
                key = local_name(type_)
                yield Declared(key, type_, param.help, kind_of(type_, known.ontology))


def _with_robot(
    known: Knowledge, params: Sequence[Declared], wanted: Sequence[Wanted]
) -> tuple[list[Declared], list[Wanted]]:
    """Adds the robot that has the devices, and the relations to them, unless the author specifies the relations."""
    if _HAS_PART not in known.catalogue.conditions:
        return list(params), []
    said = {argument for one in wanted if one.word == _HAS_PART for argument in one.arguments[1:]}
    devices = [p for p in params if p.kind is Kind.HARDWARE and p.key not in said]
    robot = next((p.key for p in params if p.is_element and known.ontology.is_a(p.type, "sk:Robot")), None)
    named = any(_ROBOT in one.arguments for one in wanted)
    if not devices and (robot or not named):
        return list(params), []
    if robot is None:
        robot = _ROBOT
        params = [params[0], Declared(robot, "sk:Robot", "The robot that has it.", Kind.PLANNING), *params[1:]]
    arm = next((p.key for p in params if p.is_element and known.ontology.is_a(p.type, "sk:Arm")), robot)
    whole = {p.key: robot if p.key == arm or _is_body(known, p) else arm for p in devices}
    return list(params), [Wanted(_HAS_PART, (whole[p.key], p.key)) for p in devices]


def _is_body(known: Knowledge, param: Declared) -> bool:
    return any(known.ontology.is_a(param.type, class_) for class_ in ("sk:Base", "sk:Arm"))


def _meant(known: Knowledge, said: NewSkill, wanted: Wanted, params: Sequence[Declared]) -> Condition:
    type_ = known.condition(wanted.word)
    keys = {param.key: param for param in params}
    for argument in wanted.arguments:
        if argument not in keys:
            raise UnknownName("parameter", argument, keys, where=f"in {wanted} of skill '{said.name}'")
    try:
        condition = type_(*wanted.arguments)
    except DescriptionError as error:
        raise UsageError(f"skill '{said.name}', {wanted}: {error}") from error
    for role, argument in zip(type_.roles, wanted.arguments, strict=True):
        _check_role(known, wanted, role.class_, keys[argument])
    return ~condition if wanted.negated else condition


def _check_role(known: Knowledge, wanted: Wanted, class_: str, param: Declared) -> None:
    if not param.is_element or not known.ontology.is_a(param.type, class_):
        raise UsageError(f"{wanted}: {param.key} is a {param.type}; it must be a {class_} there")


def _check_effect(said: NewSkill, wanted: Wanted, condition: Condition) -> None:
    try:
        effects_of(condition)
    except DescriptionError as error:
        raise UsageError(f"skill '{said.name}', --post {wanted}: {error}") from error


def _target(said: NewSkill, params: Sequence[Declared], post: Sequence[Wanted]) -> str:
    keys = [param.key for param in params]
    if said.target:
        if said.target not in keys:
            raise UnknownName("parameter", said.target, keys, where=f"as --target of skill '{said.name}'")
        return said.target
    spoken_of = [argument for one in post for argument in one.arguments]
    things = [param.key for param in params if param.kind is Kind.ONLINE and param.is_element]
    return next((key for key in things if key in spoken_of), (*things, *spoken_of)[0])


def draft_skill(known: Knowledge, said: NewSkill) -> Draft:
    """Writes a skill with an implementation for the fake robot and, of primitives, one for every other; and its test.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "skill")
    known.check_free("skill", name)
    help_ = sentence(said.help or words_of(name), "--help-text")
    skill = described(known, said)
    calls = calls_of(known, said.do, skill.params)
    package, constant = known.project.package, constant_name(name)
    imported = [known.origin(word).name for word in skill.words]
    check_distinct([constant, f"{constant}_FAKE", *imported], f"skill '{name}'")
    module = f"{package}.skills.{name}"
    entries = {name: f"{module}:{constant}"} if calls else {}
    project = known.project.with_entries("skiros.skills", {**entries, f"{name}_fake": f"{module}:{constant}_FAKE"})
    project = _depending(project, known, skill)
    stage, cast = _staged(known, said, skill)
    values: dict[str, Any] = {
        "name": name,
        "help": help_,
        "stem": name,
        "module": module,
        "constant": constant,
        "calls": calls,
    }
    scene = stage.turtle(f"What is needed to {words_of(name)}.")
    wanted = {str(one): condition for one, condition in skill.pre}
    left = open_questions(tried(known, scene, f"scene of skill '{name}'"), stage, wanted, cast)
    trial = _tried(known, said, skill, stage, cast)
    new = {
        **known.project.init_file("skills"),
        f"src/{package}/skills/{name}.py": _module(values, known, skill),
        f"tests/skills/test_{name}.py": render("skill_test.py", **values, **trial),
        f"tests/skills/scenes/{name}.ttl": scene,
    }
    notes = [f"tests/skills/scenes/{name}.ttl does not make it true: {why}; see to it by hand" for why in left]
    if not calls:
        notes.append(f"{name} is only pretended: give --do PRIMITIVE, or add an implementation later")
    return Draft(project.root, new, project.changes(known.project), tuple(notes))


def _module(values: dict[str, Any], known: Knowledge, skill: Described) -> str:
    origins = {word: known.origin(word) for word in skill.words}
    own = [(o.module, o.name) for o in origins.values() if o.module.partition(".")[0] == known.project.package]
    foreign = [(o.module, o.name) for o in origins.values() if (o.module, o.name) not in own]
    names = ["AssertEffects", *(("Do", "P", "Sequence") if values["calls"] else ())]
    needed = [("skiros_py.behaviours", name) for name in names]
    needed += [("skiros_py.skills.parameters", "Param"), *foreign]
    if any(param.kind is not Kind.ONLINE for param in skill.params):
        needed.append(("skiros_py.skills.parameters", "Kind"))
    needed += [("skiros_py.skills.skill", name) for name in ("Skill", "SkillDescription")]
    sets = (("pre", skill.pre), ("post", skill.post))
    return render(
        "skill.py",
        **values,
        needed=needed,
        own=own,
        agent=skill.agent,
        target=skill.target,
        params=[_param(param) for param in skill.params],
        conditions=[(k, [_condition(w, origins[w.word].name) for w, _ in some]) for k, some in sets if some],
    )


def _param(param: Declared) -> list[str]:
    arguments = [literal(param.key), literal(param.type), literal(param.help)]
    if param.kind is not Kind.ONLINE:
        arguments.append(f"Kind.{param.kind.name}")
    if param.default is not None:
        arguments.append(f"default={literal(param.default)}")
    return arguments + ([f"unit={literal(param.unit)}"] if param.unit else [])


def _condition(wanted: Wanted, constant: str) -> str:
    return f"{'~' if wanted.negated else ''}{constant}({', '.join(map(literal, wanted.arguments))})"


def _depending(project: Project, known: Knowledge, skill: Described) -> Project:
    """Adds the distributions that provide foreign conditions to the dependencies."""
    for word in skill.words:
        project = project.with_dependency(known.origin(word).distribution)
    return project


def _staged(known: Knowledge, said: NewSkill, skill: Described) -> tuple[Stage, Mapping[str, str]]:
    """Builds a scene in which it can be executed, with its effects as the goal.

    Returns:
        The scene, and its individuals by parameter.
    """
    stage = Stage(known.ontology, said.name, find_robot(said.robot, known.ontology))
    cast = {param.key: stage.cast(param.type, param.key) for param in skill.params if param.is_element}
    for _, condition in skill.pre:
        stage.suppose(condition.pattern, cast)
    for wanted, condition in skill.post:
        if _is_plannable(known, condition):
            stage.goals.append(str(replace(wanted, arguments=tuple(cast[argument] for argument in wanted.arguments))))
    if not stage.goals:
        raise UsageError(
            f"skill '{said.name}': its first goal cannot be what is not so; give a --post of what is so then"
        )
    return stage, cast


def _is_plannable(known: Knowledge, condition: Condition) -> bool:
    """Returns whether it is suitable as a first goal: the absence of a relation is a poor one."""
    if isinstance(condition.pattern, Not) and isinstance(condition.pattern.pattern, Related):
        return False
    try:
        expand(condition.pattern, str(condition), known.ontology, count(1))
    except PlanningError:
        return False
    return True


def _tried(known: Knowledge, said: NewSkill, skill: Described, stage: Stage, cast: Mapping[str, str]) -> dict[str, Any]:
    """Returns the data of the test: its imports, and the arguments of a trial if all primitives are the package's own.

    Foreign primitives may need real arms.
    """
    needed = [("skiros_py.station.session", "Options"), ("skiros_py.station.session", "Session")]
    origins = [known.primitive_origin(name) for name in dict.fromkeys(said.do)]
    if not origins or any(o.module.partition(".")[0] != known.project.package for o in origins):
        return {"needed": needed, "own": [], "primitives": []}
    needed += [("skiros_py.skills.outcome", "Success")]
    needed += [("skiros_py.testing", "run_skill"), ("skiros_py.testing", "world_of")]
    module = f"{known.project.package}.skills.{said.name}"
    given = [(p.key, cast.get(p.key, SAMPLES.get(p.type))) for p in skill.params if p.kind is Kind.ONLINE]
    return {
        "needed": needed,
        "own": [(module, constant_name(said.name)), *((origin.module, origin.name) for origin in origins)],
        "primitives": [origin.name for origin in origins],
        "places": [list(map(literal, place)) for place in stage.left_to_robot],
        "arguments": [f"{key}={literal(value)}" for key, value in given],
    }


# ---------------------------------------------------------------- how its body calls primitives


def calls_of(known: Knowledge, primitives: Sequence[str], params: Sequence[Declared]) -> list[list[str]]:
    """Returns the arguments of one ``Do.of`` per primitive.

    A parameter of a primitive gets the skill's of the same name, whatever its capitals, else the only one of a class
    that fits.

    Raises:
        UnknownName: There is no such primitive.
        UsageError: Nothing fits a parameter that must be given, or several do.
    """
    return [[literal(name), *_arguments(known, name, params)] for name in primitives]


def _arguments(known: Knowledge, primitive: str, params: Sequence[Declared]) -> Iterator[str]:
    for param in known.primitive(primitive):
        found = _fitting(known, param, params)
        if len(found) == 1:
            yield f"{param.key}=P({literal(found[0].key)})"
        elif param.kind in (Kind.ONLINE, Kind.HARDWARE, Kind.PLANNING):
            fit = f"{', '.join(p.key for p in found)} all fit" if found else "no parameter of the skill fits"
            raise UsageError(
                f"--do {primitive}: it needs {param.key} ({param.type}: {param.help}), and {fit}; declare --param"
                f" {param.key}:{param.type}"
            )


def _fitting(known: Knowledge, param: Param, params: Sequence[Declared]) -> list[Declared]:
    able = [p for p in params if _fits(known, p, param)]
    named = [p for p in able if p.key.casefold() == param.key.casefold()]
    return named or (able if param.is_element else [])


def _fits(known: Knowledge, own: Declared, param: Param) -> bool:
    if not isinstance(param.type, str):
        return False
    if own.is_element and param.is_element:
        return known.ontology.is_a(own.type, param.type)
    return own.type == param.type
