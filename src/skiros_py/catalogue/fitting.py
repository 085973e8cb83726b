"""Which skills can be used with an ontology."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.errors import PlanningError
from skiros_py.planning.actions import actions_of, maintain_emptiness
from skiros_py.planning.model import Action
from skiros_py.plugins import LazyPlugins, PluginFault
from skiros_py.skills.composition import Do, walk
from skiros_py.skills.lint import problems_of
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

__all__ = ["fitting"]


def fitting(
    catalogue: Catalogue, ontology: Ontology, reasoners: Reasoners = NO_REASONERS, *, fake: bool | None = None
) -> Catalogue:
    """Leaves out skills that cannot be used here; they are reported and hurt nobody else.

    A skill must use words that the ontology declares, relations that a reasoner computes and modules that exist, and it
    must be possible to plan with it beside those before it.

    Args:
        catalogue: What was found.
        ontology: The words that there are.
        reasoners: What computes relations.
        fake: True where only skills for fakes will be used, False where only the others: those that nobody will use are
            left out unseen, and what they call is not loaded. None to look at all.
    """
    wanted = {n: s for n, s in catalogue.skills.items() if fake is None or fake == (s.driver == "fake")}
    actions: dict[str, tuple[Action, ...]] = {}
    faults: dict[str, PluginFault] = {}
    for name, skill in wanted.items():
        try:
            if problems := _problems(catalogue, skill, ontology, reasoners):
                faults[name] = _fault(catalogue, name, "; ".join(problems))
            else:
                actions[name] = tuple(actions_of(skill.description, ontology))
        except PlanningError as error:
            faults[name] = _fault(catalogue, name, str(error))
        except Exception as error:  # noqa: BLE001 - to look at somebody else's description may run their code
            faults[name] = _fault(catalogue, name, f"{type(error).__name__}: {error}", traceback.format_exc())
    faults |= {name: _fault(catalogue, name, reason) for name, reason in _unplannable(actions, ontology).items()}
    good = {name: skill for name, skill in wanted.items() if name not in faults}
    return replace(catalogue, skills=good, early=(*catalogue.early, *(faults[n] for n in wanted if n in faults)))


def _problems(catalogue: Catalogue, skill: Skill, ontology: Ontology, reasoners: Reasoners) -> tuple[str, ...]:
    broken = tuple(_broken_calls(catalogue, skill))
    return broken or problems_of(skill, ontology, catalogue.primitives, reasoners)


def _fault(catalogue: Catalogue, name: str, reason: str, trace: str = "") -> PluginFault:
    source = catalogue.sources.get(f"skills/{name}", "this catalogue")
    return PluginFault("skiros.skills", name, source, reason, trace)


def _broken_calls(catalogue: Catalogue, skill: Skill) -> Iterator[str]:
    """Yields what is wrong with the primitives that a skill calls and that are there, but cannot be used."""
    called = {node.module for tree in skill.nodes for node in walk(tree) if isinstance(node, Do)}
    primitives = catalogue.primitives
    for name in sorted(called):
        reason = primitives.why_not(name) if isinstance(primitives, LazyPlugins) else None
        if reason is not None:
            yield f"it calls '{name}': {reason}"


def _unplannable(actions: Mapping[str, Sequence[Action]], ontology: Ontology) -> dict[str, str]:
    """Returns the skills that one cannot plan with beside those before them, each with the reason."""
    if _conflict(actions.values(), ontology) is None:  # nearly always, and quick for hundreds
        return {}
    reasons: dict[str, str] = {}
    good: list[Sequence[Action]] = []
    for name, own in actions.items():
        reason = _conflict([*good, own], ontology)
        if reason is None:
            good.append(own)
        else:
            reasons[name] = reason
    return reasons


def _conflict(actions: Iterable[Sequence[Action]], ontology: Ontology) -> str | None:
    different = dict.fromkeys(action for own in actions for action in own)
    try:
        maintain_emptiness(different, ontology)
    except PlanningError as error:
        return str(error)
    return None
