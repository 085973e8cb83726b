"""Skills that are installed but cannot be used, as causes why there is no plan."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from skiros_py.messages import Message
from skiros_py.planning.explanation.wording import Found
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.skills.conditions.effects import Relate, Unrelate, brought_about
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import PLACEMENT

_TERM = re.compile(r"[\w.-]+:[\w.-]+")


@dataclass(frozen=True, slots=True)
class AbsentSkill:
    """A skill that is installed but cannot be used.

    Attributes:
        fault: Why, with its name and distribution.
        changes: The relations and properties that it would change; None if it is not known.
    """

    fault: str
    changes: frozenset[str] | None = None

    @classmethod
    def of(cls, skill: SkillDescription, fault: str) -> AbsentSkill:
        """Makes one of a skill whose description is known."""
        effects = (effect for condition in skill.post for effect in brought_about(condition))
        return cls(fault, frozenset(e.relation if isinstance(e, Relate | Unrelate) else e.property for e in effects))


def absence_causes(found: Iterable[Found], absent: Sequence[AbsentSkill], ontology: Ontology) -> Iterator[Cause]:
    """Yields the absent skills that would change, or might change, a fact that no skill brings about."""
    for one in found:
        if one.reason is None or one.reason.kind not in (CauseKind.NO_SKILL, CauseKind.MISSING_FACT, CauseKind.FULL):
            continue
        missing = one.reason.missing
        wanted = _changed(_TERM.findall(missing.predicate) if missing else (), ontology)
        for skill in absent:
            if skill.changes is None:
                text = Message("perhaps a skill that cannot be used would change it: {fault}", fault=skill.fault)
            elif _changed(skill.changes, ontology) & wanted:
                text = Message("a skill would change it, but cannot be used: {fault}", fault=skill.fault)
            else:
                continue
            yield Cause(CauseKind.NO_SKILL, text, one.cause.conditions, why=skill.fault)


def _changed(terms: Iterable[str], ontology: Ontology) -> set[str]:
    """Returns relations and properties, with one word for all placements: a move changes any of them."""
    relations = ontology.relations
    return {PLACEMENT if t in relations and ontology.family(t) is Family.PLACEMENT else t for t in terms}
