"""Words must be declared and documented; computed relations must have a reasoner."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Collection, Iterable, Iterator
from functools import partial
from typing import Any

from skiros_py.errors import SkirosError, UnknownName
from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.skills.conditions import (
    ClassRelated,
    Compare,
    Computed,
    ConditionType,
    Exists,
    Expression,
    Has,
    IsA,
    Nothing,
    Pattern,
    Related,
)
from skiros_py.skills.conditions.pattern import Classes, NumberChange, leaves
from skiros_py.skills.lint.rule import Known, Place, Source, Subject, rule, uses_of
from skiros_py.skills.parameters import Param, params_of
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.ontology import Ontology

_ALIKE = 0.8
"""How much a word must be like another one that this is what was meant."""


@rule(
    "unknown-word", "A class, relation, property or signal that is not declared.",
    SkillDescription, Skill, Place, ConditionType, type, disables=True,
)  # fmt: skip
def unknown_word(subject: Subject, known: Known) -> Iterator[str]:
    """Yields words that no ontology declares, also those of signals that no kind of device offers."""
    for where, class_ in _named_classes(subject):
        yield from (f"{where}: {text}" for text in _missing("class", class_, known.ontology.classes))
    for use in uses_of(subject):
        for leaf, classes in leaves(use.pattern, use.classes):
            yield from (f"{use.where}: {text}" for text in _undeclared(leaf, classes, known))


def _named_classes(subject: Subject) -> Iterator[tuple[str, str]]:
    match subject:
        case Skill():
            yield from (("requires", class_) for class_ in subject.requires)
        case Place(node):
            yield from ((f"for each {key}", class_) for key, class_ in node.uses().binds.items())
        case ConditionType():
            yield from ((f"role {role.name}", role.class_) for role in subject.roles)
        case _:
            yield from ((f"parameter {p.key}", p.element_class) for p in own_params(subject) if p.is_element)
            outputs = [output.param for output in getattr(subject, "outputs", ())]
            yield from ((f"output {p.key}", p.element_class) for p in outputs if p.is_element)
            watched = getattr(subject, "watches", None)
            yield from (("watches", class_) for class_ in (watched,) if isinstance(class_, str))


def own_params(subject: Subject) -> tuple[Param, ...]:
    """Returns the parameters of a skill's description or of a primitive; none for anything else."""
    match subject:
        case SkillDescription(params=params):
            return params
        case Skill() | ConditionType() | Source() | Place():
            return ()
        case _:
            try:
                return params_of(subject.Params)
            except (SkirosError, AttributeError, TypeError):
                return ()  # another rule says so


def _undeclared(leaf: Pattern, classes: Classes, known: Known) -> Iterator[str]:
    ontology = known.ontology
    match leaf:
        case Related(relation) | Nothing(relation) | Computed(relation) | ClassRelated(relation):
            yield from _missing("relation", relation, ontology.relations)
        case Has(property_) | Compare(property_) | NumberChange(property_):
            yield from _missing("property", property_, ontology.properties)
        case Exists(_, class_) | IsA(_, class_):
            yield from _missing("class", class_, ontology.classes)
        case Expression():
            for device, quantity in leaf.quantities:
                class_ = classes.get(device, "")
                offered = load_device_kinds()[0].signal_names(partial(_may_be, ontology, class_))
                if class_ and quantity not in offered:
                    yield f"no {class_} has a signal '{quantity}'; there is {', '.join(sorted(offered)) or 'none'}"
                name = f"{device}.{quantity}"
                if device not in classes and known.signals is not None and name not in known.signals:
                    yield str(UnknownName("signal", name, known.signals))
        case _:
            yield f"its pattern {type(leaf).__name__} is not known"


def _may_be(ontology: Ontology, class_: str, kind: str) -> bool:
    """Returns whether a device of a class may be of a kind: there is none of a kind whose class is not declared."""
    return kind in ontology.classes and ontology.overlap(class_, kind)


def _missing(kind: str, word: str, declared: Collection[str]) -> Iterator[str]:
    if word not in declared:
        yield f"no ontology declares the {kind} {word}{nearest(word, declared)}"


def nearest(word: str, known: Iterable[str]) -> str:
    """Returns the question whether a known word was meant, where one is alike; else an empty text."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=_ALIKE)
    return f"; did you mean {near[0]}?" if near else ""


@rule(
    "not-computed", "A computed relation without a reasoner.",
    SkillDescription, Skill, Place, ConditionType, disables=True,
)  # fmt: skip
def not_computed(subject: Subject, known: Known) -> Iterator[str]:
    """Yields computed relations without a function that no reasoner computes."""
    for use in uses_of(subject):
        for leaf, _ in leaves(use.pattern):
            if isinstance(leaf, Computed) and leaf.function is None and not known.reasoners.computes(leaf.relation):
                yield f"{use.where}: no reasoner computes {leaf.relation}, and no function is given for it"


_SHORTEST = 3
"""Shorter help texts are no help."""


@rule("missing-help", "A missing or too short help text.", SkillDescription, ConditionType, type)
def missing_help(subject: Subject, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields what has no help text, or one that is too short."""
    text = subject.help if isinstance(subject, SkillDescription | ConditionType) else _docstring(subject)
    if len(text.strip()) < _SHORTEST:
        yield "say in one sentence what it is for"
    for param in own_params(subject):
        if len(param.help.strip()) < _SHORTEST:
            yield f"say in one sentence what parameter {param.key} is for"
    for output in getattr(subject, "outputs", ()):
        if len(output.help.strip()) < _SHORTEST:
            yield f"say in one sentence what output {output.name} means"


def _docstring(class_: Any) -> str:
    """Returns a class's own docstring, without the one that a dataclass writes by itself."""
    text = inspect.cleandoc(class_.__dict__.get("__doc__") or "")
    return "" if text.startswith(f"{class_.__name__}(") else text


@rule("missing-unit", "A number without a unit.", SkillDescription, type)
def missing_unit(subject: Subject, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields numbers without a unit."""
    outputs = [output.param for output in getattr(subject, "outputs", ())]
    for kind, params in (("parameter", own_params(subject)), ("output", outputs)):
        for param in params:
            if param.type in ("number", "vector") and not param.unit:
                yield f"say the unit of {kind} {param.key}; a ratio has the unit '1', a count is an integer"
