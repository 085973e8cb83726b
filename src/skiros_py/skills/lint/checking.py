"""All rules, in the order in which they are asked, and what asks them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from types import MappingProxyType

from skiros_py.errors import UnknownName
from skiros_py.skills.behaviour import Behaviour, nodes_of
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
    leaves,
    title,
    uses_of_node,
    walk_scoped,
)
from skiros_py.skills.lint.rules.calls import (
    MISSING_ARGUMENT,
    MISSING_PARAMETER,
    RECURSIVE_SKILL,
    UNKNOWN_MODULE,
    wrong_call,
)
from skiros_py.skills.lint.rules.code import BLOCKING_CALL, MOTION_IN_FINALLY, PRETENDS, PRIVATE_IMPORT, YIELD_NEVER
from skiros_py.skills.lint.rules.devices import NO_MIX_RULE, SAME_DEVICE, taken_twice
from skiros_py.skills.lint.rules.ranges import WRONG_RANGE, wrong_ends
from skiros_py.skills.lint.rules.reach import IMPOSSIBLE_EFFECT, MOVES_BY_STRUCTURE, UNPLACED, UNREACHABLE_PRECONDITION
from skiros_py.skills.lint.rules.words import MISSING_HELP, MISSING_UNIT, NOT_COMPUTED, UNKNOWN_WORD, undeclared_in
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

DOES_NOT_LOAD = Rule("does-not-load", Severity.ERROR, "A plug-in that cannot be loaded.")
EFFECT_MISSING = Rule("effect-missing", Severity.ERROR, "A skill ran, and an effect it declares did not happen.")
UNDECLARED_CHANGE = Rule("undeclared-change", Severity.ERROR, "A skill ran, and changed what it does not declare.")
NEVER_TRIED = Rule("never-tried", Severity.WARNING, "A skill for which no world to try it in was found.")

_ALL = (
    DOES_NOT_LOAD,
    UNKNOWN_WORD,
    NOT_COMPUTED,
    UNPLACED,
    UNKNOWN_MODULE,
    MISSING_ARGUMENT,
    MISSING_PARAMETER,
    WRONG_RANGE,
    IMPOSSIBLE_EFFECT,
    UNREACHABLE_PRECONDITION,
    RECURSIVE_SKILL,
    SAME_DEVICE,
    NO_MIX_RULE,
    PRETENDS,
    MOVES_BY_STRUCTURE,
    MISSING_HELP,
    MISSING_UNIT,
    YIELD_NEVER,
    MOTION_IN_FINALLY,
    BLOCKING_CALL,
    PRIVATE_IMPORT,
    EFFECT_MISSING,
    UNDECLARED_CHANGE,
    NEVER_TRIED,
)

RULES: Mapping[str, Rule] = MappingProxyType({one.name: one for one in _ALL})
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
            found = Finding(rule.name, rule.severity, title(subject), problem.text, problem.spot or spot)
            if rule.name not in allowed.get(found.spot.line if found.spot else 0, ()):
                yield found


def _contained(rule: Rule, subject: Subject, known: Known) -> Iterator[Problem]:
    try:
        yield from _asked(rule, subject, known)
    except Exception as error:  # noqa: BLE001 - looking at a plug-in's objects may run their code
        yield Problem(f"it cannot be looked at: {type(error).__name__}: {error}")


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
    return tuple(p.text for s in subjects for rule in rules for p in _asked(rule, s, known))


def _asked(rule: Rule, subject: Subject, known: Known) -> Iterator[Problem]:
    return rule.check(subject, known) if rule.check is not None else iter(())


def faults_of_document(
    root: Behaviour, params: Sequence[Param], known: Known, documents: Collection[str]
) -> Iterator[tuple[str, str]]:
    """Yields what is wrong with what a document does, with the path of the node in it.

    These are calls of modules that are not there, words that are not declared, expressions that can never hold, and
    branches that run at the same time and both take one device.

    Args:
        root: What it does.
        params: Its parameters.
        known: The modules.
        documents: Names of the documents that it may call as modules.
    """
    classes = {param.key: param.element_class for param in params if param.is_element}
    paths = (node.path.lstrip("/") for node in nodes_of(root, ""))
    for path, (node, scope) in zip(paths, walk_scoped(root, classes), strict=True):
        calls = (call for call in node.uses().calls if call.module not in documents)
        uses = list(uses_of_node(node, scope))
        patterns = (leaf for use in uses for leaf in leaves(use.pattern, use.classes))
        found = chain(
            (text for call in calls for text in wrong_call(call, known)),
            (text for leaf in patterns for text in undeclared_in(*leaf, known)),
            (text for use in uses for text in wrong_ends(use, known.ontology)),
            taken_twice(node, scope, known),
        )
        yield from ((path, text) for text in found)
