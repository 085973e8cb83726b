"""Sequence numbers while a task is under way: what goes wrong late does not send a robot back to a lower number."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from skiros_py.station.session import Options, Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.trace import TraceEventKind

STARTER = "ObjectAtLocation(starter_1, kit_1_a)"
COMPRESSOR = "ObjectAtLocation(compressor_1, kit_1_b)"


@pytest.fixture
def session() -> Iterator[Session]:
    """The kitting cell, where pallet A (with the starter) has number 1 and pallet B (with the compressor) number 2."""
    with Session("kitting", Options(fake=True)) as made:
        with made.world.transaction("operator", "numbers") as tx:
            tx.set("floor", "sk:useSequenceNumbers", True)
            tx.set("pallet_a", "sk:sequenceNumber", 1)
            tx.set("pallet_b", "sk:sequenceNumber", 2)
        yield made


def until(session: Session, reached: Callable[[], bool], cycles: int = 40_000) -> None:
    for _ in range(cycles):
        if reached():
            return
        session.cycle.step()
    raise AssertionError("it was never reached")


def visited(task: TaskHandle) -> list[str]:
    return [
        e.arguments["Location"] for e in task.trace.entries if e.what is TraceEventKind.ENDED and e.skill == "drive"
    ]


def move(session: Session, part: str, place: str) -> None:
    with session.world.transaction("somebody", "moved it by hand") as tx:
        tx.place(part, "sk:in", place)


def test_pallets_are_visited_in_the_order_of_their_numbers(session: Session) -> None:
    task = session.tasks.begin(session.parse([STARTER, COMPRESSOR]))
    until(session, lambda: task.done)

    assert task.report is not None
    assert task.report.reached
    assert [place for place in visited(task) if place.startswith("pallet")] == ["pallet_a", "pallet_b"]


def test_a_part_lost_after_a_higher_number_was_visited_is_given_up_with_that_reason(session: Session) -> None:
    task = session.tasks.begin(session.parse([STARTER, COMPRESSOR]))
    until(session, lambda: "pallet_b" in visited(task))
    move(session, "starter_1", "pallet_a")  # out of the kit again, where it lay
    until(session, lambda: task.done)

    assert task.report is not None
    assert task.report.outcome is Outcome.PARTLY_REACHED, str(task.trace)
    starter, compressor = task.report.conditions
    assert "sequence number" in starter.reason
    assert compressor.believed
    assert "pallet_a" not in visited(task)[visited(task).index("pallet_b") :]


def test_a_part_lost_before_a_higher_number_is_visited_is_fetched_again_first(session: Session) -> None:
    task = session.tasks.begin(session.parse([STARTER, COMPRESSOR]))
    until(session, lambda: session.world.related("starter_1", "sk:in", "kit_1_a"))
    move(session, "starter_1", "pallet_a")
    until(session, lambda: task.done)

    assert task.report is not None
    assert task.report.reached, str(task.trace)
    assert [place for place in visited(task) if place.startswith("pallet")] == ["pallet_a", "pallet_a", "pallet_b"]


def test_the_next_task_starts_again_at_the_lowest_number(session: Session) -> None:
    first = session.tasks.begin(session.parse([COMPRESSOR]))
    until(session, lambda: first.done)
    second = session.tasks.begin(session.parse([STARTER]))
    until(session, lambda: second.done)

    assert second.report is not None
    assert second.report.reached, str(second.trace)
