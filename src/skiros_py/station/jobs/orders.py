"""Orders as they come in become orders as the queue takes them; the same order again is known as the same."""

from __future__ import annotations

import hashlib
import secrets

from pydantic import ValidationError

from skiros_py.api.faults import fault_words
from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import JobOrder as Ordered
from skiros_py.errors import UsageError
from skiros_py.station.jobs.templates import TemplateStore
from skiros_py.station.jobs.texts import goal_texts
from skiros_py.tasks.jobs import JobOrder
from skiros_py.tasks.jobs.order import Material
from skiros_py.tasks.policy import Policy

LONGEST = 64 << 10
"""Length of an order, with its goal and everything else that it says [bytes]."""

_NO_IDS = frozenset({".", ".."})
"""Parts of an address that mean something else."""


def new_id() -> str:
    """Makes the id of a job whose order has none."""
    return f"job-{secrets.token_hex(8)}"


def digest_of(ordered: Ordered, *, start: bool) -> str:
    """Returns what stands for the content of a request, whatever the order of its fields."""
    return hashlib.sha256(f"{start} {ordered.model_dump_json(by_alias=True)}".encode()).hexdigest()


def texts_of(ordered: GoalOrder, templates: TemplateStore) -> tuple[str, ...]:
    """Returns the goal texts of an order.

    Raises:
        UnknownName: There is no such template, or it has no such parameter.
        UsageError: The goal is built wrongly, a parameter is missing, the material does not fit, or it is too long.
    """
    _check_length("the order", len(ordered.model_dump_json(by_alias=True).encode()))
    if not ordered.work_master:
        return goal_texts(ordered.goal)
    texts = templates.texts(ordered.work_master, ordered.parameters, ordered.materials)
    _check_length(f"what goal template '{ordered.work_master}' makes of it", sum(len(text.encode()) for text in texts))
    return texts


def _check_length(what: str, number: int) -> None:
    """Refuses what would fill memory, disk and every answer, job by job."""
    if number > LONGEST:
        raise UsageError(f"{what} has {number} bytes, and {LONGEST} are allowed: order it in several jobs")


def job_order(ordered: Ordered, id_: str, goal: tuple[str, ...]) -> JobOrder:
    """Makes an order for the queue.

    Args:
        ordered: What came in.
        id_: Id of the job.
        goal: Its goal texts.

    Raises:
        UsageError: The id cannot be one.
    """
    if id_ in _NO_IDS:
        raise UsageError(f"'{id_}' cannot be the id of a job: it means something else in an address")
    try:
        return JobOrder(
            id=id_,
            goal=goal,
            description=ordered.description,
            priority=ordered.priority,
            not_before=ordered.not_before,
            deadline=ordered.deadline,
            expires=ordered.expires,
            policy=Policy(**ordered.policy.model_dump()),
            work_master=ordered.work_master,
            parameters=dict(ordered.parameters),
            materials=tuple(Material(**material.model_dump()) for material in ordered.materials),
        )
    except ValidationError as error:
        faults = ((".".join(map(str, one["loc"])), fault_words(one)) for one in error.errors())
        raise UsageError("; ".join(f"{field}: {_said(field, words)}" for field, words in faults)) from None


def is_same(ordered: Ordered, known: JobOrder) -> bool:
    """Returns whether what came in is what was ordered before.

    What a template has made of it counts as it did then: the template may have changed since, or be gone.

    Raises:
        UsageError: The goal is built wrongly.
    """
    goal = known.goal if ordered.work_master else goal_texts(ordered.goal)
    return job_order(ordered, known.id, goal) == known


def _said(field: str, words: str) -> str:
    return "1 to 200 characters without blanks, '/' and control characters" if field == "id" else words
