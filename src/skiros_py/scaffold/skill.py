"""Writes a skill: its preconditions and effects, and its real or pretended implementation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.domain.literals import expand
from skiros_py.scaffold.declared import Declared, Wanted
from skiros_py.scaffold.description import Described, NewSkill, described
from skiros_py.scaffold.draft import Draft
from skiros_py.scaffold.knowledge import Knowledge
from skiros_py.scaffold.primitive import SAMPLES
from skiros_py.scaffold.project import Project
from skiros_py.scaffold.rendering import literal, render
from skiros_py.scaffold.robots import find_robot
from skiros_py.scaffold.spelling import check_distinct, constant_name, module_name, sentence, words_of
from skiros_py.scaffold.stage import Stage
from skiros_py.scaffold.trial import open_questions, tried
from skiros_py.skills.conditions import Condition, Not, Related
from skiros_py.skills.parameters import Kind, Param


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
