"""Writes a primitive: parameters and an execution."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from skiros_py.authoring import SkillBase
from skiros_py.errors import UsageError
from skiros_py.scaffold.declared import PYTHON_TYPES, joined, module_name, read_parameter, words_of
from skiros_py.scaffold.draft import Draft, literal, render
from skiros_py.scaffold.orders import NewPrimitive
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.stage import Stage
from skiros_py.skills.parameters import Param
from skiros_py.skills.parameters.fields import names_of_runs
from skiros_py.skills.parameters.values import SAMPLES

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


def draft_primitive(known: Knowledge, said: NewPrimitive) -> Draft:
    """Writes a primitive, its test with a scene, and its entry point.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "primitive")
    known.check_free("primitive", name)
    class_ = joined(name)
    values = known.project.names("primitives", name, name, said.help or words_of(name), class_name=class_)
    params = tuple(read_parameter(text, known.ontology) for text in said.params)
    check_keys(params, f"primitive '{name}'")
    stage = Stage(known, name, said.robot)
    arguments = list(_trial_arguments(params, stage))
    texts = (
        render("primitive.py", **values, **declarations(params)),
        render("primitive_test.py", **values, arguments=arguments),
        stage.turtle(f"A robot that can {words_of(name)}."),
    )
    return known.project.module_draft("primitives", name, {name: class_}, texts)


def check_keys(params: Sequence[Param], owner: str) -> None:
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
    if taken := sorted(names_of_runs(SkillBase).intersection(keys)):
        raise UsageError(f"{owner}: every run has something called '{taken[0]}'; choose another name for the parameter")
    for key in keys:
        module_name(key, f"parameter of {owner}:")


def declarations(params: Sequence[Param]) -> dict[str, Any]:
    """Returns what a template needs to declare parameters in a class: what precedes their arguments, and these."""
    heads = [f"{param.key}: {PYTHON_TYPES.get(param.type_name, 'str')} = param" for param in params]
    return {
        "kinds": any(param.kind.name in _SAID for param in params),
        "fields": list(zip(heads, map(_arguments_of, params), strict=True)),
        "seconds": any(param.key == "seconds" and param.type == "number" for param in params),
    }


_SAID = ("HARDWARE", "PLANNING")
"""Kinds that a declaration says: the others follow from whether there is a default."""


def _arguments_of(param: Param) -> list[str]:
    given = (
        (f"kind=Kind.{param.kind.name}", param.kind.name in _SAID),
        (f"default={literal(param.default)}", param.default is not None),
        (f"unit={literal(param.unit)}", param.unit),
    )
    return [literal(param.type), literal(param.help), *(text for text, is_given in given if is_given)]


def _trial_arguments(params: Iterable[Param], stage: Stage) -> Iterator[str]:
    """Yields the arguments of the test: individuals of a scene, and example values if there is no default."""
    for param in params:
        if param.default is None:
            element = stage.cast(param.element_class, param.key) if param.is_element else None
            yield f"{param.key}={literal(element or SAMPLES[param.type_name])}"
