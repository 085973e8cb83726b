"""Words must be declared and documented; computed relations must have a reasoner."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Collection, Iterator

from skiros_py.errors import SkirosError, UnknownName
from skiros_py.ports.kinds import load_device_kinds
from skiros_py.skills.behaviour import walk
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
from skiros_py.skills.lint.rule import Classes, Known, Problem, Rule, Severity, Source, Subject, leaves, uses_of
from skiros_py.skills.parameters import Param, params_of
from skiros_py.skills.skill import Skill, SkillDescription

_ALIKE = 0.8
"""How much a word must be like another one that this is what was meant."""


def _undeclared(subject: Subject, known: Known) -> Iterator[Problem]:
    ontology = known.ontology
    for where, class_ in _named_classes(subject):
        yield from (Problem(f"{where}: {text}") for text in _missing("class", class_, ontology.classes))
    for use in uses_of(subject):
        for leaf, classes in leaves(use.pattern, use.classes):
            yield from (Problem(f"{use.where}: {text}") for text in undeclared_in(leaf, classes, known))


def _named_classes(subject: Subject) -> Iterator[tuple[str, str]]:
    match subject:
        case Skill():
            yield from (("requires", class_) for class_ in subject.requires)
            bound = (one for node in subject.nodes for below in walk(node) for one in below.uses().binds.items())
            yield from ((f"for each {key}", class_) for key, class_ in bound)
        case ConditionType():
            yield from ((f"role {role.name}", role.class_) for role in subject.roles)
        case _:
            yield from ((f"parameter {p.key}", p.element_class) for p in own_params(subject) if p.is_element)
            watched = getattr(subject, "watches", None)
            yield from (("watches", class_) for class_ in (watched,) if isinstance(class_, str))


def own_params(subject: Subject) -> tuple[Param, ...]:
    """Returns the parameters of a skill's description or of a primitive; none for anything else."""
    match subject:
        case SkillDescription(params=params):
            return params
        case Skill() | ConditionType() | Source():
            return ()
        case _:
            try:
                return params_of(subject.Params)
            except (SkirosError, AttributeError, TypeError):
                return ()  # another rule says so


def undeclared_in(leaf: Pattern, classes: Classes, known: Known) -> Iterator[str]:
    """Yields the words of a pattern that are not declared."""
    ontology = known.ontology
    match leaf:
        case Related(relation) | Nothing(relation) | Computed(relation) | ClassRelated(relation):
            yield from _missing("relation", relation, ontology.relations)
        case Has(property_) | Compare(property_):
            yield from _missing("property", property_, ontology.properties)
        case Exists(_, class_) | IsA(_, class_):
            yield from _missing("class", class_, ontology.classes)
        case Expression():
            offered = load_device_kinds()[0].signal_names()
            for device, quantity in leaf.quantities:
                if device in classes and quantity not in offered:
                    yield f"no device has a signal '{quantity}'; there is {', '.join(sorted(offered))}"
                name = f"{device}.{quantity}"
                if device not in classes and known.signals is not None and name not in known.signals:
                    yield str(UnknownName("signal", name, known.signals))
        case _:
            yield f"its pattern {type(leaf).__name__} is not known"


def _missing(kind: str, word: str, declared: Collection[str]) -> Iterator[str]:
    if word not in declared:
        near = difflib.get_close_matches(word, declared, n=1, cutoff=_ALIKE)
        yield f"no ontology declares the {kind} {word}{f'; did you mean {near[0]}?' if near else ''}"


def _uncomputed(subject: Subject, known: Known) -> Iterator[Problem]:
    for use in uses_of(subject):
        for leaf, _ in leaves(use.pattern):
            match leaf:
                case Computed(relation, _, _, None) if not known.reasoners.computes(relation):
                    yield Problem(f"{use.where}: no reasoner computes {relation}, and no function is given for it")
                case _:
                    pass


UNKNOWN_WORD = Rule(
    "unknown-word", Severity.ERROR, "A class, relation, property or signal that is not declared.", _undeclared, True
)
NOT_COMPUTED = Rule(
    "not-computed", Severity.ERROR, "A computed relation that no reasoner works out.", _uncomputed, True
)


_SHORTEST = 3
"""Shorter help texts are no help."""


def _unexplained(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    match subject:
        case Skill() | Source():
            return
        case SkillDescription(help=help_) | ConditionType(help=help_):
            said = help_
        case _:
            said = _docstring(subject)
    if len(said.strip()) < _SHORTEST:
        yield Problem("say in one sentence what it is for")
    for param in own_params(subject):
        if len(param.help.strip()) < _SHORTEST:
            yield Problem(f"say in one sentence what parameter {param.key} is for")


def _docstring(class_: type) -> str:
    """Returns a class's own docstring, without the one that a dataclass writes by itself."""
    text = inspect.cleandoc(class_.__dict__.get("__doc__") or "")
    return "" if text.startswith(f"{class_.__name__}(") else text


def _without_unit(subject: Subject, known: Known) -> Iterator[Problem]:  # noqa: ARG001 - a check's signature
    for param in own_params(subject):
        if param.type in ("number", "vector") and not param.unit:
            yield Problem(
                f"say the unit of parameter {param.key}; a mere ratio has the unit '1', a count is an integer"
            )


MISSING_HELP = Rule("missing-help", Severity.ERROR, "Nothing says what it is for.", _unexplained)
MISSING_UNIT = Rule("missing-unit", Severity.ERROR, "A number whose unit nothing says.", _without_unit)
