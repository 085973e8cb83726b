"""All rules, in the order in which they are asked, and what asks them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType

from skiros_py.errors import UnknownName
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.lint.rule import (
    Finding,
    Known,
    PrimitiveClass,
    Problem,
    Rule,
    Severity,
    Source,
    Spot,
    Subject,
    places_of,
    title,
)
from skiros_py.skills.lint.rules import calls, code, devices, ranges, reach, words
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

DOES_NOT_LOAD = Rule("does-not-load", Severity.ERROR, "A plug-in that cannot be loaded.")
EFFECT_MISSING = Rule("effect-missing", Severity.ERROR, "A declared effect of a skill did not happen when it ran.")
UNDECLARED_CHANGE = Rule("undeclared-change", Severity.ERROR, "A skill changed something undeclared when it ran.")
NEVER_TRIED = Rule("never-tried", Severity.WARNING, "No world was found in which the skill can start.")

_OF_CODE = (one for module in (words, reach, calls, ranges, devices, code) for one in vars(module).values())
_ALL = (DOES_NOT_LOAD, *_OF_CODE, EFFECT_MISSING, UNDECLARED_CHANGE, NEVER_TRIED)
_OF_DOCUMENTS = (
    calls.unknown_module,
    calls.missing_argument,
    calls.not_yet_written,
    words.unknown_word,
    ranges.wrong_range,
    devices.same_device,
)

RULES: Mapping[str, Rule] = MappingProxyType({one.name: one for one in _ALL if isinstance(one, Rule)})
"""Every rule, by name."""


def rule(name: str) -> Rule:
    """Returns the rule of that name.

    Raises:
        UnknownName: There is none.
    """
    if name not in RULES:
        raise UnknownName("rule", name, RULES)
    return RULES[name]


_ALLOWED = re.compile(r"#\s*skiros:\s*allow\s+([a-z-]+(?:\s*,\s*[a-z-]+)*)")


def check(
    subject: Subject, known: Known, spot: Spot | None = None, rules: Iterable[Rule] = RULES.values()
) -> Iterator[Finding]:
    """Yields which rules a thing breaks.

    What a line of a source says after ``# skiros: allow RULE`` is allowed there.

    Args:
        subject: The thing.
        known: What it may refer to.
        spot: Where it is defined.
        rules: Rules to ask.
    """
    allowed = _allowances(subject) if isinstance(subject, Source) else {}
    for rule in rules:
        for problem in _contained(rule, subject, known):
            text, line = problem if isinstance(problem, tuple) else (problem, None)
            at = Spot(subject.file, line) if isinstance(subject, Source) and line is not None else spot
            if rule.name not in allowed.get(at.line if at else 0, ()):
                yield Finding(rule.name, rule.severity, title(subject), text, at)


def _contained(rule: Rule, subject: Subject, known: Known) -> Iterator[Problem]:
    try:
        yield from rule.problems(subject, known)
    except Exception as error:  # noqa: BLE001 - looking at a plug-in's objects may run their code
        yield f"it cannot be inspected: {type(error).__name__}: {error}"


def _allowances(source: Source) -> Mapping[int, Sequence[str]]:
    lines = enumerate(source.text.splitlines(), start=1)
    return {n: re.split(r"\s*,\s*", said[1]) for n, line in lines if (said := _ALLOWED.search(line))}


def problems_of(
    skill: Skill,
    ontology: Ontology,
    primitives: Mapping[str, PrimitiveClass],
    reasoners: Reasoners = NO_REASONERS,
    skills: Sequence[Skill] = (),
) -> tuple[str, ...]:
    """Returns why a skill cannot be used: undeclared words, relations without a reasoner, calls of unknown modules.

    Args:
        skill: The skill.
        ontology: The words.
        primitives: The primitives that it may call.
        reasoners: What computes relations.
        skills: The skills that it may call, itself among them.
    """
    known = Known(ontology, primitives, skills, reasoners)
    rules = [rule for rule in RULES.values() if rule.disables]
    subjects: tuple[Subject, ...] = (skill.description, skill)
    return tuple(str(found) for one in subjects for rule in rules for found in rule.problems(one, known))


def faults_of_document(root: Behaviour, params: Sequence[Param], known: Known) -> Iterator[tuple[str, str]]:
    """Yields what is wrong with what a document does, with the path of the node in it.

    These are calls that are wrong or never end, values of the wrong type or not yet written, words that are not
    declared, expressions that can never hold, and branches that run at the same time and both take one device.

    Args:
        root: What it does.
        params: Its parameters.
        known: The modules, and the documents that it may call as modules.
    """
    endless = calls.endless_modules(known, known.skills)
    for place in places_of(root, params):
        for module in sorted({call.module for call in place.node.uses().calls} & endless):
            yield place.path, f"{module} leads to calls in a circle, which never end: write loops with repeat or retry"
        for rule in _OF_DOCUMENTS:
            yield from ((place.path, str(found)) for found in rule.problems(place, known))
