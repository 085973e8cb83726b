"""Which skills can be used with an ontology."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Iterator
from dataclasses import replace

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.catalogue.clashes import called_by, callers_of_broken
from skiros_py.errors import PlanningError
from skiros_py.interruptions import by_user
from skiros_py.planning.domain.actions import actions_of
from skiros_py.plugins import LazyPlugins, PluginFault
from skiros_py.skills.lint import problems_of
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners


def fitting(
    catalogue: Catalogue, ontology: Ontology, reasoners: Reasoners = NO_REASONERS, *, fake: bool | None = None
) -> Catalogue:
    """Leaves out skills that cannot be used here; they are reported.

    A skill must use words that the ontology declares, relations that a reasoner computes and modules that exist and can
    themselves be used, and it must be possible to plan with it.

    Args:
        catalogue: What was found.
        ontology: The words that there are.
        reasoners: What computes relations.
        fake: True where only skills for fakes will be used, False where only the others: those that are not used are
            left out unseen, and what they call is not loaded. None to look at all.
    """
    wanted = {n: s for n, s in catalogue.skills.items() if fake is None or fake == _is_fake(s)}
    sides = {side: {n: s for n, s in wanted.items() if _is_fake(s) is side} for side in (True, False)}
    faults: dict[str, PluginFault] = {}
    for name, skill in wanted.items():
        try:
            if problems := _problems(catalogue, skill, sides[_is_fake(skill)].values(), ontology, reasoners):
                faults[name] = _fault(catalogue, name, "; ".join(problems))
            else:
                actions_of(skill.description.under([skill.when]), ontology)
        except PlanningError as error:
            faults[name] = _fault(catalogue, name, str(error))
        except BaseException as error:
            if by_user(error):
                raise
            faults[name] = _fault(catalogue, name, f"{type(error).__name__}: {error}", traceback.format_exc())
    reasons = {name: fault.reason for name, fault in faults.items()}
    for side in sides.values():  # those for fakes and the others never meet in one run, so they cannot call each other
        faults |= {name: _fault(catalogue, name, reason) for name, reason in callers_of_broken(side, reasons).items()}
    good = {name: skill for name, skill in wanted.items() if name not in faults}
    early = (*catalogue.early, *(faults[n] for n in wanted if n in faults))
    elsewhere = _names(catalogue.skills.values()) - _names(wanted.values())
    return replace(catalogue, skills=good, early=early, elsewhere=elsewhere, fake=bool(fake))


def _names(skills: Iterable[Skill]) -> frozenset[str]:
    return frozenset(skill.description.name for skill in skills)


def _is_fake(skill: Skill) -> bool:
    return skill.driver == "fake"


def _problems(
    catalogue: Catalogue, skill: Skill, beside: Iterable[Skill], ontology: Ontology, reasoners: Reasoners
) -> tuple[str, ...]:
    broken = tuple(_broken_calls(catalogue, skill))
    return broken or problems_of(skill, ontology, catalogue.primitives, reasoners, tuple(beside))


def _fault(catalogue: Catalogue, name: str, reason: str, trace: str = "") -> PluginFault:
    source = catalogue.sources.get(f"skills/{name}", "this catalogue")
    return PluginFault("skiros.skills", name, source, reason, trace)


def _broken_calls(catalogue: Catalogue, skill: Skill) -> Iterator[str]:
    """Yields what is wrong with the modules that a skill calls and that are there, but cannot be used."""
    primitives = catalogue.primitives
    unloaded = {fault.name: fault for fault in catalogue.early if fault.group == "skiros.skills"}
    there = {other.description.name for other in catalogue.skills.values()}
    for name in called_by(skill):
        reason = primitives.why_not(name) if isinstance(primitives, LazyPlugins) else None
        if reason is not None:
            yield f"it calls '{name}': {reason}"
        elif name in unloaded and name not in there and name not in primitives:
            yield f"it calls '{name}': {unloaded[name]}"
