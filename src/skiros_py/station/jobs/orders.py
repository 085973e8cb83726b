"""Converts incoming orders into orders of the queue, and recognises repeated orders."""

from __future__ import annotations

import hashlib

from pydantic import ValidationError

from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import JobOrder as Ordered
from skiros_py.api.wire import fault_field, fault_words
from skiros_py.errors import UsageError
from skiros_py.messages import Message
from skiros_py.station.document_store import TEMPLATE, DocumentStore
from skiros_py.station.jobs.template_document import content_of, filled, goal_texts
from skiros_py.tasks.jobs.job import JobOrder

LONGEST = 64 << 10
"""Maximum size of an order, with its goal and all other fields [bytes]."""

_NO_IDS = frozenset({".", ".."})
"""Path segments with a different meaning."""

_ID = "1 to 200 printable characters without blanks and '/'"


def digest_of(ordered: Ordered, *, start: bool) -> str:
    """Returns a digest of the content of a request that does not depend on the order of its fields."""
    return hashlib.sha256(f"{start} {ordered.model_dump_json(by_alias=True)}".encode()).hexdigest()


def texts_of(ordered: GoalOrder, documents: DocumentStore) -> tuple[str, ...]:
    """Returns the goal texts of an order.

    Raises:
        UnknownName: There is no such template, or it has no such parameter.
        UsageError: The goal is malformed, a parameter is missing, the material does not fit, or it is too long.
    """
    _check_length("the order", len(ordered.model_dump_json(by_alias=True).encode()))
    if not ordered.work_master:
        return goal_texts(ordered.goal)
    content = content_of(documents.find(TEMPLATE, ordered.work_master).data)
    texts = goal_texts(filled(ordered.work_master, content, ordered.parameters, ordered.materials))
    _check_length(
        Message("what goal template '{name}' makes of it", name=ordered.work_master),
        sum(len(text.encode()) for text in texts),
    )
    return texts


def _check_length(what: str, number: int) -> None:
    """Refuses values so long that they would fill memory, disk and every answer."""
    if number > LONGEST:
        raise UsageError(
            "{what} has {number} bytes, and {longest} are allowed: order it in several jobs",
            what=what,
            number=number,
            longest=LONGEST,
        )


def job_order(ordered: Ordered, id_: str, goal: tuple[str, ...]) -> JobOrder:
    """Returns an order for the queue.

    Args:
        ordered: The incoming order.
        id_: Id of the job.
        goal: Its goal texts.

    Raises:
        UsageError: The id is not valid.
    """
    if id_ in _NO_IDS:
        raise UsageError("'{job}' cannot be the id of a job: it means something else in an address", job=id_)
    if not id_.isprintable():  # such as a character that reverses the order of those that follow
        raise UsageError(f"id: {_ID}")
    try:
        return JobOrder.model_validate(ordered.model_dump(by_alias=True) | {"id": id_, "goal": goal})
    except ValidationError as error:
        faults = ((fault_field(one), fault_words(one)) for one in error.errors())
        raise UsageError("; ".join(f"{field}: {_said(field, words)}" for field, words in faults)) from None


def is_same(ordered: Ordered, known: JobOrder) -> bool:
    """Returns whether an incoming order is the same as a known one.

    For a template, the goals produced at the time of the known order count: it may have been changed or removed since.

    Raises:
        UsageError: The goal is malformed.
    """
    goal = known.goal if ordered.work_master else goal_texts(ordered.goal)
    return job_order(ordered, known.id, goal) == known


def _said(field: str, words: str) -> str:
    return _ID if field == "id" else words
