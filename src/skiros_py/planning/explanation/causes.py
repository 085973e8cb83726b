"""The causes found without search: facts that never become true, and goal conditions that exclude each other.

Shortages of things or places are found without search; nothing here depends on the order of skills.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from skiros_py.messages import Message
from skiros_py.planning.domain.literals import CAN
from skiros_py.planning.domain.matching import is_variable
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.explanation.contradictions import Contradictions
from skiros_py.planning.explanation.unreachable import UnreachableFacts
from skiros_py.planning.explanation.wording import Found, Reason
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A


def find_causes(task: PlanningTask) -> tuple[Found, ...]:
    """Returns the cause of each condition that can never hold by itself, then those of mutually exclusive conditions.

    Each proves by itself that there is no plan, also with sequence numbers or in time. Empty if each condition could
    hold and no simple conflict prevents them from holding together.
    """
    relaxed = Relaxation(with_everyone(task), together=True)
    facts = UnreachableFacts(relaxed)
    found: list[Found] = []
    for condition, atoms in relaxed.task.goal:
        missing = next((atom for atom in atoms if atom not in relaxed.facts), None)
        if missing is not None:
            found.append(_unreachable(condition, facts.of(missing), task.view))
    return _main_first(found, Contradictions(_cleared(found, relaxed)).found())


def _cleared(found: Sequence[Found], relaxed: Relaxation) -> Relaxation:
    """Returns the facts reachable if the occupied places were empty: conditions exclusive even then are exclusive."""
    full = [one.reason for one in found if one.reason is not None and one.reason.kind is CauseKind.FULL]
    empty = [atom for one in full if (atom := one.missing) is not None and not any(map(is_variable, atom.arguments))]
    if not empty:
        return relaxed
    problem = relaxed.task.problem
    supposed = replace(problem, init=problem.init.union(empty))
    return Relaxation(replace(relaxed.task, problem=supposed), together=True)


def _main_first(hopeless: Sequence[Found], together: Sequence[Found]) -> tuple[Found, ...]:
    """Puts conflicts over one place first, since they persist however the place is cleared.

    For conditions that are hopeless in any place or in that one, only that reason is given; for a place wanted by
    several conditions, it is not also reported that one of their things occupies it.
    """
    reasons = {one.cause.conditions[0]: one.reason for one in hopeless}
    rivals = [one for one in together if one.shortage is not None and _is_rivalry(one.cause, reasons)]
    taken = [one for one in hopeless if not any(_covers(rivalry.cause, one) for rivalry in rivals)]
    rest = [one for one in together if one not in rivals and not reasons.keys() & set(one.cause.conditions)]
    return (*rivals, *taken, *rest)


def _is_rivalry(cause: Cause, reasons: Mapping[Condition, Reason | None]) -> bool:
    """Returns whether several conditions compete for one place where each alone could eventually be fulfilled."""
    known = [reason for condition in cause.conditions if (reason := reasons.get(condition)) is not None]
    one_day = all(reason.kind in (CauseKind.FULL, CauseKind.MISSING_FACT) for reason in known)
    return cause.kind is CauseKind.CONTRADICTION and len(cause.conditions) > 1 and one_day


def _covers(rivalry: Cause, one: Found) -> bool:
    """Returns whether a place is occupied by the thing that another of the competing conditions wants there."""
    reason = one.reason
    if reason is None or reason.kind is not CauseKind.FULL:
        return False
    return one.cause.conditions[0] in rivalry.conditions and set(reason.elements) <= set(rivalry.elements)


def _unreachable(condition: Condition, reason: Reason, view: WorldView) -> Found:
    full = _full(condition, reason, view)
    why, core = reason.text, reason.core or reason.text
    for whole in reversed(full):
        why, core = (Message("{whole} is full: {why}", whole=whole, why=one) for one in (why, core))
    parts = reason.skill, reason.precondition, (*full, *reason.elements), core
    text = Message("{conditions} cannot be reached: {why}", conditions=condition, why=why)
    return Found(Cause(reason.kind, text, (condition,), *parts), reason)


def _full(condition: Condition, reason: Reason, view: WorldView) -> tuple[str, ...]:
    """Returns the elements named by the condition that consist of the occupied places, such as the full kit."""
    if reason.kind is not CauseKind.FULL:
        return ()
    named = (argument for argument in condition.arguments if view.has(argument))
    return tuple(whole for whole in named if set(view.objects(whole, HAS_A)).intersection(reason.elements))


def with_everyone(task: PlanningTask) -> PlanningTask:
    """Returns a task in which every agent of the right class takes part, with or without the skill.

    Raises:
        PlanningError: It cannot be expressed in PDDL.
    """
    everyone = [Capability(c.skill, task.view.instances(c.skill.agent_class)) for c in task.capabilities]
    able = {Atom(CAN + c.skill.name, (agent,)) for c in task.capabilities for agent in c.agents}
    whole = build_task(task.view, everyone, task.conditions)
    init = frozenset(atom for atom in whole.problem.init if not atom.predicate.startswith(CAN) or atom in able)
    return replace(whole, problem=replace(whole.problem, init=init), capabilities=task.capabilities)
