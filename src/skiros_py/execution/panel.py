"""The condition panel of a module (paper Fig. 6): what it would be run with, what holds, and why something does not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.execution.claims import complete
from skiros_py.execution.module_faults import contained
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.inference.inferring import Inferred, Missing, infer
from skiros_py.skills.outcome import Failure
from skiros_py.skills.parameters import Kind, Param, missing, read_arguments
from skiros_py.skills.parameters.values import as_json
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class ConditionRow:
    """One condition of a skill.

    Attributes:
        kind: "pre", "hold" or "post".
        condition: In words.
        verdict: Whether it holds now, and why; None where a parameter is still open.
    """

    kind: str
    condition: str
    verdict: Verdict | None

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "kind": self.kind,
            "condition": self.condition,
            "holds": None if self.verdict is None else self.verdict.holds,
            "why": [] if self.verdict is None else self.verdict.lines()[1:],
        }


@dataclass(frozen=True, slots=True)
class Panel:
    """What a module would be run with now.

    Attributes:
        params: Its parameters.
        values: What is specified or inferred, by key.
        reasons: Why this value, for inferred ones.
        missing: Parameters that stay open, with the reason.
        rows: Its conditions; none for a primitive.
    """

    params: tuple[Param, ...]
    values: Mapping[str, Any]
    reasons: Mapping[str, str]
    missing: Mapping[str, str]
    rows: tuple[ConditionRow, ...] = ()

    @property
    def ready(self) -> bool:
        """True when it can be started: every parameter is specified and every precondition holds."""
        return not self.missing and all(row.verdict for row in self.rows if row.kind != "post")

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "ready": self.ready,
            "arguments": {p.key: as_json(p, self.values.get(p.key)) for p in self.params},
            "inferred": dict(self.reasons),
            "missing": dict(self.missing),
            "conditions": [row.as_json() for row in self.rows],
        }


def skill_panel(description: SkillDescription, given: Mapping[str, Any], view: WorldView, agent: str) -> Panel:
    """Looks at a skill as a subsystem would run it now.

    Raises:
        UsageError: Something is wrong with what is given.
    """
    read = read_arguments(description.params, given, view)
    found = _inferred(description, complete(view, [description.param(description.agent)], read, agent), view)
    open_ = {key: v.text for key, v in found.verdicts.items()} if isinstance(found, Missing) else {}
    reasons = {} if isinstance(found, Missing) else found.reasons
    kinds = (("pre", description.needs), ("hold", description.hold), ("post", description.post))
    left_out = {p.key for p in description.params if p.kind is Kind.OPTIONAL and found.values.get(p.key) is None}
    rows = tuple(
        _row(kind, c, found.values, view)
        for kind, conditions in kinds
        for c in conditions
        if not left_out.intersection(c.arguments)  # not evaluated
    )
    return Panel(description.params, found.values, reasons, open_, rows)


def _inferred(description: SkillDescription, given: Mapping[str, Any], view: WorldView) -> Inferred | Missing:
    """Infers what is left out; where an author's condition breaks, that stays open, and says why."""
    found = contained("inference", lambda: infer(description, given, view))
    if not isinstance(found, Failure):
        return found
    return Missing({key: Verdict(False, found.reason) for key in missing(description.params, given)}, given)


def primitive_panel(params: Sequence[Param], given: Mapping[str, Any], view: WorldView, agent: str) -> Panel:
    """Looks at a primitive as a subsystem would run it now.

    Raises:
        UsageError: Something is wrong with what is given.
    """
    values = complete(view, params, read_arguments(params, given, view), agent)
    return Panel(tuple(params), values, {}, dict.fromkeys(missing(params, values), "not specified"))


def _row(kind: str, condition: Condition, values: Mapping[str, Any], view: WorldView) -> ConditionRow:
    if any(values.get(argument) is None for argument in condition.arguments):
        return ConditionRow(kind, str(condition), None)
    found = contained("it", lambda: condition.evaluate(view, values))
    verdict = Verdict(False, str(condition), (Verdict(False, found.reason),)) if isinstance(found, Failure) else found
    return ConditionRow(kind, str(condition), verdict)
