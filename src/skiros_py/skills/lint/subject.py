"""What rules look at, and what they may look up."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from skiros_py.errors import SkirosError
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.parameters import Param, params_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription
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


Subject = SkillDescription | Skill | PrimitiveClass | ConditionType | Source
"""One thing of a plug-in."""


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
        case _:
            return f"primitive {getattr(subject, 'name', subject.__name__)}"


@dataclass(frozen=True, slots=True)
class Known:
    """What is there beside the thing that is looked at.

    Attributes:
        ontology: The words.
        primitives: All primitives, by name.
        skills: All skills.
        reasoners: What computes relations.
    """

    ontology: Ontology
    primitives: Mapping[str, PrimitiveClass]
    skills: Sequence[Skill] = ()
    reasoners: Reasoners = NO_REASONERS

    def implementations(self, skill: str) -> tuple[Skill, ...]:
        """Returns the implementations of a skill."""
        return tuple(s for s in self.skills if s.description.name == skill)

    def params(self, module: str) -> tuple[Param, ...] | None:
        """Returns the parameters of a primitive or a skill; None where there is none, or its own are broken."""
        if module in self.primitives:
            try:
                return params_of(self.primitives[module].Params)
            except SkirosError:
                return None
        return next((s.description.params for s in self.implementations(module)), None)

    def takes(self, module: str) -> tuple[str, ...]:
        """Returns the keys of those parameters of a module whose element it takes with all its devices."""
        if module in self.primitives:
            return self.primitives[module].takes
        return tuple(key for s in self.implementations(module) for key in s.takes)
