"""Locks keep other people and jobs from editing for a while, and never a skill from saying what it sensed."""

from __future__ import annotations

import math
import threading

import pytest

from skiros_py.errors import Locked, UsageError
from skiros_py.world.change import Writer
from skiros_py.world.locks import Lock, Locks
from skiros_py.world.world import World


class Clock:
    """A clock that goes when it is told to."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def locks(clock: Clock) -> Locks:
    return Locks(clock)


def names(locks: Locks) -> list[str]:
    return [lock.element for lock in locks.held()]


def write(world: World, author: str, writer: Writer, element: str = "starter_1") -> None:
    with world.transaction(author, "because", writer=writer) as tx:
        tx.set(element, "sk:missedLooks", world.version)


# ------------------------------------------------------------ taking and giving back


def test_a_lock_names_its_element_its_owner_and_its_end(locks: Locks) -> None:
    taken = locks.acquire(["kit_1", "arm_1", "kit_1"], "ann", 10)

    assert taken == (Lock("arm_1", "ann", 110.0), Lock("kit_1", "ann", 110.0))
    assert locks.held() == taken


def test_a_single_id_can_be_locked_without_a_list(locks: Locks) -> None:
    locks.acquire("kit_1", "ann", 10)
    assert names(locks) == ["kit_1"]

    locks.release("ann", "kit_1")
    assert names(locks) == []


def test_all_elements_are_locked_or_none(locks: Locks) -> None:
    locks.acquire(["b"], "ann", 10)

    with pytest.raises(Locked, match="b is locked by ann for 10 s more"):
        locks.acquire(["a", "b", "c"], "bob", 10)

    assert names(locks) == ["b"]


def test_every_element_that_is_locked_is_named(locks: Locks) -> None:
    locks.acquire(["a"], "ann", 10)
    locks.acquire(["b"], "bob", 20)

    with pytest.raises(Locked) as caught:
        locks.acquire(["a", "b"], "eve", 10)

    assert str(caught.value) == "a is locked by ann for 10 s more; b is locked by bob for 20 s more"


def test_a_lock_ends_by_itself(locks: Locks, clock: Clock) -> None:
    locks.acquire(["a"], "ann", 10)
    clock.now += 9.9
    assert locks.fault(["a"], "bob")

    clock.now += 0.1

    assert locks.held() == ()
    assert not locks.fault(["a"], "bob")
    assert locks.acquire(["a"], "bob", 10) == (Lock("a", "bob", 120.0),)


def test_acquiring_a_lock_again_extends_it(locks: Locks, clock: Clock) -> None:
    locks.acquire(["a"], "ann", 10)
    clock.now += 8
    locks.acquire(["a"], "ann", 10)
    clock.now += 8

    assert names(locks) == ["a"]


def test_only_the_owner_can_release_a_lock(locks: Locks) -> None:
    locks.acquire(["a", "b"], "ann", 10)
    locks.acquire(["c"], "bob", 10)

    locks.release("bob", ["a", "nobody"])
    assert names(locks) == ["a", "b", "c"]

    locks.release("ann", ["a"])
    assert names(locks) == ["b", "c"]

    locks.release("ann")
    assert names(locks) == ["c"]


@pytest.mark.parametrize("seconds", [0, -1, math.nan, math.inf, 24 * 3600 + 1])
def test_the_duration_of_a_lock_must_be_positive_and_at_most_one_day(locks: Locks, seconds: float) -> None:
    with pytest.raises(UsageError, match="more than 0 s and at most 86400 s"):
        locks.acquire(["a"], "ann", seconds)

    assert locks.held() == ()


@pytest.mark.parametrize("owner", ["", "  "])
def test_a_lock_has_an_owner(locks: Locks, owner: str) -> None:
    with pytest.raises(UsageError, match="a lock needs an owner"):
        locks.acquire(["a"], owner, 10)


def test_exactly_one_of_many_threads_acquires_a_lock(locks: Locks) -> None:
    together = threading.Barrier(8)
    got: list[str] = []

    def want(owner: str) -> None:
        together.wait()
        try:
            locks.acquire(["a", "b"], owner, 10)
        except Locked:
            return
        got.append(owner)

    threads = [threading.Thread(target=want, args=(f"owner {number}",)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert len(got) == 1
    assert [lock.owner for lock in locks.held()] == got * 2


# ------------------------------------------------------------ locks and writers


@pytest.mark.parametrize("writer", [Writer.PERSON, Writer.JOB])
def test_people_and_jobs_cannot_edit_an_element_locked_by_another_author(world: World, writer: Writer) -> None:
    world.locks.acquire(["starter_1"], "ann", 60)
    before = world.version

    with pytest.raises(Locked, match=r"transaction of bob \(because\) refused: starter_1 is locked by ann"):
        write(world, "bob", writer)

    assert world.version == before
    assert world.value("starter_1", "sk:missedLooks") is None


@pytest.mark.parametrize("writer", [Writer.SKILL, Writer.SYSTEM])
def test_skills_and_the_platform_can_edit_locked_elements(world: World, writer: Writer) -> None:
    world.locks.acquire(["starter_1"], "ann", 60)

    write(world, "look", writer)

    assert world.value("starter_1", "sk:missedLooks") is not None


def test_the_owner_of_a_lock_edits_and_others_do_where_nothing_is_locked(world: World) -> None:
    world.locks.acquire(["starter_1"], "ann", 60)

    write(world, "ann", Writer.PERSON)
    write(world, "bob", Writer.PERSON, "relay_box_1")

    assert world.version == 3


def test_a_place_that_is_locked_takes_and_gives_nothing(world: World) -> None:
    world.locks.acquire(["pallet_a"], "ann", 60)

    for part, place in (("compressor_1", "pallet_a"), ("starter_1", "pallet_b")):
        with pytest.raises(Locked, match="pallet_a"), world.transaction("bob", "because", writer=Writer.PERSON) as tx:
            tx.place(part, "sk:in", place)


def test_the_whole_of_a_locked_piece_is_edited_but_not_removed(world: World) -> None:
    world.locks.acquire(["kit_1_a"], "ann", 60)

    write_label(world, "kit_1")
    with pytest.raises(Locked, match="kit_1_a"), world.transaction("bob", "because", writer=Writer.PERSON) as tx:
        tx.remove("kit_1")

    assert world.element("kit_1").label == "mine"


@pytest.mark.parametrize(("first", "second"), [("kit_1", "kit_1_a"), ("kit_1_a", "kit_1")])
def test_the_parts_and_the_whole_of_a_locked_element_cannot_be_locked_by_another_author(
    world: World, first: str, second: str
) -> None:
    world.locks.acquire([first], "ann", 60)

    with pytest.raises(Locked, match=f"{first} is locked by ann"):
        world.locks.acquire([second], "bob", 60)
    world.locks.acquire([second], "ann", 60)


def test_a_lock_acquired_during_a_transaction_refuses_its_commit(world: World) -> None:
    def write_slowly() -> None:
        with world.transaction("bob", "because", writer=Writer.PERSON) as tx:
            tx.set("starter_1", "sk:missing", True)
            world.locks.acquire(["starter_1"], "ann", 60)

    with pytest.raises(Locked, match="starter_1 is locked by ann"):
        write_slowly()


def write_label(world: World, element: str) -> None:
    with world.transaction("bob", "because", writer=Writer.PERSON) as tx:
        tx.set(element, "rdfs:label", "mine")
