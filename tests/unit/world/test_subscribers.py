"""Everyone is told of each change, in order, and nobody's fault is another's."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import pytest

from skiros_py.errors import WorldError
from skiros_py.world.change import Change
from skiros_py.world.world import World


def count(world: World, looks: int, author: str = "look") -> None:
    with world.transaction(author, "not there") as tx:
        tx.set("starter_1", "sk:missedLooks", looks)


def test_a_change_is_visible_when_subscribers_are_notified(world: World) -> None:
    seen: list[object] = []
    world.subscribe(lambda change: seen.append((change.number, world.version, world.value(*LOOKS))))

    count(world, 1)
    count(world, 2)

    assert seen == [(2, 2, 1), (3, 3, 2)]


def test_subscribers_are_notified_in_the_order_of_subscription(world: World) -> None:
    told: list[tuple[str, int]] = []
    for name in ("first", "second", "third"):
        world.subscribe(lambda change, name=name: told.append((name, change.number)))  # type: ignore[misc]

    count(world, 1)

    assert told == [("first", 2), ("second", 2), ("third", 2)]


def test_changes_without_effect_notify_no_subscriber(world: World) -> None:
    told: list[Change] = []
    world.subscribe(told.append)

    with world.transaction("look", "nothing new"):
        pass
    with pytest.raises(WorldError), world.transaction("look", "nonsense") as tx:
        tx.set("starter_1", "sk:mass", "heavy")

    assert told == []


def test_an_exception_in_a_subscriber_is_logged_and_affects_no_other_subscriber(
    world: World, caplog: pytest.LogCaptureFixture
) -> None:
    told: list[int] = []

    def fail(_: Change) -> None:
        raise ZeroDivisionError

    world.subscribe(fail)
    world.subscribe(lambda change: told.append(change.number))
    with caplog.at_level(logging.ERROR):
        count(world, 1)
        count(world, 2)

    assert told == [2, 3]
    assert [record.getMessage() for record in caplog.records] == [
        f"a subscriber failed on change {number} of the world" for number in (2, 3)
    ]


def test_changes_by_a_subscriber_are_sent_to_all_after_the_change_it_received(world: World) -> None:
    before, after, told_meanwhile = list[int](), list[int](), list[int]()

    def react(change: Change) -> None:
        if change.author == "look":
            count(world, 10, "reaction")
            told_meanwhile.extend(before)

    world.subscribe(lambda change: before.append(change.number))
    world.subscribe(react)
    world.subscribe(lambda change: after.append(change.number))
    count(world, 1)

    assert told_meanwhile == [2]
    assert before == after == [2, 3]
    assert world.value(*LOOKS) == 10


def test_a_removed_subscriber_does_not_receive_the_change_being_delivered(world: World) -> None:
    told: list[int] = []
    stops: list[Callable[[], None]] = []
    world.subscribe(lambda _: stops[0]())
    stops.append(world.subscribe(lambda change: told.append(change.number)))

    count(world, 1)

    assert told == []


def test_a_subscriber_that_removes_itself_receives_only_the_current_change(world: World) -> None:
    first, last = list[int](), list[int]()

    def once(change: Change) -> None:
        first.append(change.number)
        stop()

    stop = world.subscribe(once)
    world.subscribe(lambda change: last.append(change.number))
    count(world, 1)
    count(world, 2)
    stop()  # again, which does no harm

    assert first == [2]
    assert last == [2, 3]


def test_a_subscriber_added_during_delivery_receives_only_later_changes(world: World) -> None:
    late: list[int] = []
    world.subscribe(lambda change: world.subscribe(lambda later: late.append(later.number)) and None)

    count(world, 1)
    assert late == []

    count(world, 2)
    assert late == [3]


def test_a_subscriber_added_within_a_transaction_receives_it(world: World) -> None:
    told: list[int] = []
    with world.transaction("look", "not there") as tx:
        world.subscribe(lambda change: told.append(change.number))
        tx.set(*LOOKS, 1)

    assert told == [2]


def test_a_function_subscribed_twice_is_called_twice(world: World) -> None:
    told: list[Change] = []
    stop = world.subscribe(told.append)
    world.subscribe(told.append)
    count(world, 1)
    assert len(told) == 2

    stop()
    count(world, 2)
    assert len(told) == 3


def test_changes_of_many_threads_are_delivered_once_and_in_order(world: World) -> None:
    told: list[int] = []
    world.subscribe(lambda change: told.append(change.number))

    def work(name: str) -> None:
        for looks in range(25):
            with world.transaction(name, "looked") as tx:
                tx.set(name, "sk:missedLooks", looks)

    threads = [threading.Thread(target=work, args=(name,)) for name in world.instances("kitting:Part")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert told == list(range(2, 2 + 25 * len(threads)))


LOOKS = ("starter_1", "sk:missedLooks")
