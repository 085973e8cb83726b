"""Writes a primitive: parameters and an execution."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.scaffold.declared import (
    VALUE_TYPES,
    Declared,
    check_distinct,
    joined,
    module_name,
    read_parameter,
    sentence,
    words_of,
)
from skiros_py.scaffold.draft import Draft, literal, render
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.robot import find_robot
from skiros_py.scaffold.stage import Stage
from skiros_py.skills.parameters import Kind

SAMPLES: Mapping[str, Any] = {"number": 1.0, "integer": 1, "text": "text", "boolean": True}
"""An example value of each type."""

_OF_TEST_KIT = frozenset(
    {
        "answers",
        "config",
        "driver",
        "faults",
        "limit",
        "ports",
        "primitive",
        "primitives",
        "self",
        "skill",
        "skills",
        "world",
    }
)
"""Names that parameters of a module cannot have where a test gives them by name."""


@dataclass(frozen=True, slots=True)
class NewPrimitive:
    """The author's options for a primitive.

    Attributes:
        name: Its name ("read_code").
        help: One sentence; derived from the name if omitted.
        params: Its parameters (``camera:sk:Camera``, ``seconds:number=1.0 [s]``).
        robot: Name of the robot in its test.
    """

    name: str
    help: str = ""
    params: tuple[str, ...] = ()
    robot: str = "mobile_panda"


def draft_primitive(known: Knowledge, said: NewPrimitive) -> Draft:
    """Writes a primitive, its test with a scene, and its entry point.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "primitive")
    known.check_free("primitive", name)
    check_distinct([joined(name)], f"primitive '{name}'")
    help_ = sentence(said.help or words_of(name), "--help-text")
    params = tuple(read_parameter(text, known.ontology) for text in said.params)
    check_keys(params, f"primitive '{name}'")
    for param in params:
        module_name(param.key, f"parameter of primitive '{name}':")
    package = known.project.package
    module, class_ = f"{package}.primitives.{name}", joined(name)
    project = known.project.with_entries("skiros.primitives", {name: f"{module}:{class_}"})
    stage = Stage(known.ontology, name, find_robot(said.robot, known.ontology))
    values = {"name": name, "help": help_, "stem": name, "module": module, "class_name": class_}
    arguments = list(_trial_arguments(params, stage))
    new = {
        **known.project.init_file("primitives"),
        f"src/{package}/primitives/{name}.py": _module(values, params),
        f"tests/primitives/test_{name}.py": render("primitive_test.py", **values, arguments=arguments),
        f"tests/primitives/scenes/{name}.ttl": stage.turtle(f"A robot that can {words_of(name)}."),
    }
    return Draft(project.root, new, project.changes(known.project))


def check_keys(params: Sequence[Declared], owner: str) -> None:
    """Checks that every parameter has a unique name.

    Raises:
        UsageError: Two have the same, or one has a name that the test kit needs for itself.
    """
    keys = [param.key for param in params]
    twice = [key for key in keys if keys.count(key) > 1]
    if twice:
        raise UsageError(f"{owner} has two parameters '{twice[0]}'")
    if taken := sorted(_OF_TEST_KIT.intersection(keys)):
        raise UsageError(f"{owner}: a parameter '{taken[0]}' could not be given in a test; choose another name")


def _module(values: dict[str, str], params: Sequence[Declared]) -> str:
    in_order = sorted(params, key=lambda param: param.default is not None)  # those with a default come last
    seconds = any(param.key == "seconds" and param.type == "number" for param in params)
    fields = [{"head": f"{p.key}: {VALUE_TYPES.get(p.type, 'str')} = param", "arguments": _field(p)} for p in in_order]
    return render(
        "primitive.py",
        **values,
        needed=_imports(params),
        fields=fields,
        seconds="self.params.seconds" if seconds else "",
    )


def _field(param: Declared) -> list[str]:
    arguments = [literal(param.type), literal(param.help)]
    if param.kind is not Kind.ONLINE:
        arguments.append(f"kind=Kind.{param.kind.name}")
    if param.default is not None:
        arguments.append(f"default={literal(param.default)}")
    return arguments + ([f"unit={literal(param.unit)}"] if param.unit else [])


def _imports(params: Iterable[Declared]) -> list[tuple[str, str]]:
    names = ["Failure", "Outcome", "Success"]
    needed = [("skiros_py.skills.outcome", name) for name in names]
    needed += [("skiros_py.skills.primitive", name) for name in ("Execution", "Primitive")]
    if params:
        needed.append(("skiros_py.skills.parameters", "param"))
    if any(param.kind is not Kind.ONLINE for param in params):
        needed.append(("skiros_py.skills.parameters", "Kind"))
    return needed


def _trial_arguments(params: Iterable[Declared], stage: Stage) -> Iterator[str]:
    """Yields the arguments of the test: individuals of a scene, and example values if there is no default."""
    for param in params:
        if param.default is None:
            value: Any = stage.cast(param.type, param.key) if param.is_element else SAMPLES[param.type]
            yield f"{param.key}={literal(value)}"
