"""Rules for plug-ins, what they look at, and what they find."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Any

from skiros_py.errors import SkirosError
from skiros_py.skills.behaviour import Behaviour, Uses, walk
from skiros_py.skills.conditions import Condition, ConditionType, Pattern
from skiros_py.skills.conditions.pattern import Classes
from skiros_py.skills.parameters import IT, Output, Param, params_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import RunnableDocument, Skill, SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

PrimitiveClass = type[Primitive[Any]]


class Source:
    """A Python file of a plug-in.

    Attributes:
        file: The file.
        text: What is in it.
        tree: The same, parsed.
        names: What its names stand for, by name, where its module was imported.
        has_primitives: Whether primitives are written in it.
    """

    def __init__(
        self, file: Path, text: str, names: Mapping[str, Any] | None = None, has_primitives: bool = False
    ) -> None:
        self.file = file
        self.text = text
        self.tree = ast.parse(text, str(file))
        self.names = names or {}
        self.has_primitives = has_primitives

    @cached_property
    def imported(self) -> Mapping[str, str]:
        """What its imports are called there: dotted name by own name ("sleep" -> "time.sleep")."""
        found: dict[str, str] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    own = alias.asname or alias.name.partition(".")[0]
                    found[own] = alias.name if alias.asname else own
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                found |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
        return found

    def dotted(self, node: ast.expr) -> str:
        """Returns the full name of what an expression names ("time.sleep"), or nothing."""
        if isinstance(node, ast.Name):
            return self.imported.get(node.id, node.id)
        if isinstance(node, ast.Attribute):
            owner = self.dotted(node.value)
            return f"{owner}.{node.attr}" if owner else ""
        return ""


Writers = Mapping[str, frozenset[tuple[str, str]]]
"""Values that nodes write, by name: for each call that does so, its module and which output."""


@dataclass(frozen=True, slots=True)
class Place:
    """A node of a body or document, with the values that it can refer to.

    Attributes:
        node: The node.
        classes: Class of each element that it can refer to, by key.
        values: The parameters that are no elements, by key.
        path: Its path below the root; empty for the root.
        description: Of the skill that it is part of, or None.
        written: What may have been written when it runs.
        later: Names of all values that the body or document writes.
    """

    node: Behaviour
    classes: Classes
    values: Mapping[str, Param] = field(default_factory=dict)
    path: str = ""
    description: SkillDescription | None = None
    written: Writers = field(default_factory=dict)
    later: frozenset[str] = frozenset()

    def below(self) -> Iterator[Place]:
        """Yields this place and those of all nodes below it."""
        yield self
        uses, children = self.node.uses(), self.node.named_children()
        classes, written = {**self.classes, **uses.binds}, self.written
        if not uses.in_order:
            written = _merged(written, writers(self.node))
        for key, child in children.items():
            path = f"{self.path}/{key}".lstrip("/")
            yield from replace(self, node=child, classes=classes, path=path, written=written).below()
            if uses.in_order:
                written = _merged(written, writers(child))


def writers(root: Behaviour) -> Writers:
    """Returns what a node and all below it write."""
    found: Writers = {}
    for node in walk(root):
        found = _merged(found, _own_writers(node.uses()))
    return found


def _own_writers(uses: Uses) -> Writers:
    calls = {(name, (call.module, key)) for call in uses.calls for key, name in call.outputs.items()}
    return {name: frozenset(call for written, call in calls if written == name) for name in uses.writes}


def _merged(one: Writers, other: Writers) -> Writers:
    return {name: one.get(name, frozenset()) | other.get(name, frozenset()) for name in (*one, *other)}


Subject = SkillDescription | Skill | PrimitiveClass | ConditionType | Source | Place
"""One thing of a plug-in."""


def places_of(root: Behaviour, params: Sequence[Param], description: SkillDescription | None = None) -> Iterator[Place]:
    """Yields the places of a body or document over some parameters."""
    values = {param.key: param for param in params if not param.is_element}
    later = frozenset(name for node in walk(root) for name in node.uses().writes)
    yield from Place(root, classes_of(params), values, description=description, later=later).below()


def classes_of(params: Sequence[Param]) -> Classes:
    """Returns the classes of element parameters, by key."""
    return {param.key: param.element_class for param in params if param.is_element}


def title(subject: Subject) -> str:
    """Returns how a thing is called in messages."""
    match subject:
        case SkillDescription(name=name):
            return f"skill {name}"
        case Skill(description=description, driver=driver, label=label):
            kind = " ".join(filter(None, (label, f"({driver})" if driver else "")))
            return f"skill {description.name}{' ' + kind if kind else ''}"
        case ConditionType(name=name):
            return f"condition {name}"
        case Source(file=file):
            return file.name
        case Place(path=path):
            return f"node {path}"
        case _:
            return f"primitive {getattr(subject, 'name', getattr(subject, '__name__', ''))}"


@dataclass(frozen=True, slots=True)
class Known:
    """What is there beside the thing that is looked at.

    Attributes:
        ontology: The words.
        primitives: All primitives, by name.
        skills: All skills.
        reasoners: What computes relations.
        signals: The signals of the cell; None where there is no cell, only descriptions.
        documents: The documents that can be called as modules, by name; None for one that cannot run now.
    """

    ontology: Ontology
    primitives: Mapping[str, PrimitiveClass]
    skills: Sequence[Skill] = ()
    reasoners: Reasoners = NO_REASONERS
    signals: Collection[str] | None = None
    documents: Mapping[str, RunnableDocument | None] = field(default_factory=dict)

    def implementations(self, skill: str) -> tuple[Skill, ...]:
        """Returns the implementations of a skill."""
        return tuple(s for s in self.skills if s.description.name == skill)

    def params(self, module: str) -> tuple[Param, ...] | None:
        """Returns the parameters of a module; None where there is none, or its own are broken or not declared."""
        if module in self.primitives:
            try:
                return params_of(self.primitives[module].Params)
            except SkirosError:
                return None
        if document := self.documents.get(module):
            return document.params or None
        return next((s.description.params for s in self.implementations(module)), None)

    def outputs(self, module: str) -> tuple[str, ...]:
        """Returns the names of the outputs of a module."""
        document = self.documents.get(module)
        return tuple(output.name for output in self._outputs(module)) or (document.outputs if document else ())

    def types(self, calls: Collection[tuple[str, str]], seen: Collection[str] = ()) -> tuple[Param, ...]:
        """Returns the declared types of outputs of modules; of a document those of the outputs that it writes.

        Args:
            calls: Modules, each with the name of an output.
            seen: Documents that call these.
        """
        found: list[Param] = []
        for module, key in calls:
            found += [output.param for output in self._outputs(module) if output.name == key]
            if (document := self.documents.get(module)) and module not in seen:
                found += self.types(writers(document.behaviour).get(key, ()), (*seen, module))
        return tuple(found)

    def _outputs(self, module: str) -> tuple[Output, ...]:
        return self.primitives[module].outputs if module in self.primitives else ()

    def takes(self, module: str) -> tuple[str, ...]:
        """Returns the keys of those parameters of a module whose element it takes with all its devices."""
        if module in self.primitives:
            return self.primitives[module].takes
        return tuple(key for s in self.implementations(module) for key in s.takes)


class Severity(StrEnum):
    """How bad it is to break a rule."""

    ERROR = "error"
    """It cannot work, or not as its author means it."""
    WARNING = "warning"
    """It may work, but is likely to surprise."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A place in source code.

    Attributes:
        file: The file.
        line: 1-based line.
    """

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that something breaks.

    Attributes:
        rule: Name of the rule.
        severity: How bad that is.
        subject: What breaks it ("skill pick").
        text: What is wrong, and what would be right.
        spot: Where in the source, or None where that is not known.
    """

    rule: str
    severity: Severity
    subject: str
    text: str
    spot: Spot | None = None

    def __str__(self) -> str:
        where = f"{self.spot}: " if self.spot is not None else ""
        return f"{where}{self.rule}: {self.subject}: {self.text}"

    def as_json(self) -> dict[str, Any]:
        """Returns plain data."""
        return {
            "rule": self.rule,
            "severity": self.severity.value,
            "subject": self.subject,
            "text": self.text,
            "file": str(self.spot.file) if self.spot else None,
            "line": self.spot.line if self.spot else None,
        }


Problem = str | tuple[str, int]
"""What is wrong with one thing and what would be right; in a source also the line."""

Check = Callable[[Any, Known], Iterator[Problem]]
"""Yields what is wrong with a thing of the types that its rule is about."""

_PAGES = Path(__file__).parent / "pages"


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule for plug-ins.

    Attributes:
        name: Its name ("unknown-word").
        severity: How bad it is to break it.
        summary: One line for people.
        about: What it looks at: :class:`Place` for each node of a skill's body or a document, ``type`` for primitives.
        check: What finds it; None where it shows only when a plug-in is loaded or run.
        disables: Whether a skill that breaks it is left out: it could only fail.
    """

    name: str
    severity: Severity
    summary: str
    about: tuple[type, ...] = ()
    check: Check | None = None
    disables: bool = False

    def problems(self, subject: Subject, known: Known) -> Iterator[Problem]:
        """Yields what is wrong with a thing; nothing for things that the rule is not about."""
        if self.check is None:
            return
        if isinstance(subject, self.about):
            yield from self.check(subject, known)
        if Place in self.about and isinstance(subject, Skill):
            for root in subject.nodes:
                for place in places_of(root, subject.description.params, subject.description):
                    yield from self.check(place, known)

    @property
    def page(self) -> str:
        """What there is to say about it, as Markdown, with an example that breaks it and one that does not."""
        return (_PAGES / f"{self.name}.md").read_text(encoding="utf-8")


def rule(
    name: str, summary: str, *about: type, severity: Severity = Severity.ERROR, disables: bool = False
) -> Callable[[Check], Rule]:
    """Makes a rule of the function that checks it; see :class:`Rule`."""
    return lambda check: Rule(name, severity, summary, about, check, disables)


@dataclass(frozen=True, slots=True)
class Use:
    """A pattern at a place where it is used.

    Attributes:
        where: The place, for messages ("condition InKit(Object, Kit)").
        pattern: The pattern.
        classes: What its free variables stand for.
        condition: The condition that it is the pattern of, or None.
    """

    where: str
    pattern: Pattern
    classes: Classes
    condition: Condition | None = None


def uses_of(subject: Subject) -> Iterator[Use]:
    """Yields every pattern that a thing uses itself; those of a skill's body are at its places."""
    match subject:
        case SkillDescription(params=params):
            classes = classes_of(params)
            yield from _of_conditions((*subject.pre, *subject.hold, *subject.post), classes)
            for param in params:
                for pattern in (*param.described, *param.preferred):
                    yield Use(f"parameter {param.key}", pattern, {**classes, IT: str(param.type)})
        case Skill():
            yield from _of_conditions(subject.when, classes_of(subject.description.params))
        case Place(node, classes):
            uses = node.uses()
            yield from _of_conditions(uses.conditions, classes)
            for where, pattern in uses.patterns:
                yield Use(where, pattern, {**classes, **uses.binds})
        case ConditionType():
            yield Use("its pattern", subject.pattern, {role.name: role.class_ for role in subject.roles})
        case _:
            pass


def _of_conditions(conditions: tuple[Condition, ...], classes: Classes) -> Iterator[Use]:
    yield from (Use(f"condition {c}", c.pattern, classes, c) for c in conditions)
