"""Who may write: locks, kinds of writers, names and reasons."""

from __future__ import annotations

import pytest

from skiros_py.errors import Locked, UsageError
from skiros_py.world.change import Writer
from skiros_py.world.world import World


@pytest.mark.parametrize("writer", [Writer.PERSON, Writer.JOB])
def test_a_lock_on_a_kit_includes_its_compartments(world: World, writer: Writer) -> None:
    world.locks.acquire(["kit_1"], "anna", 60)

    with (
        pytest.raises(Locked, match="kit_1 is locked by anna"),
        world.transaction("bob", "puts it in", writer=writer) as tx,
    ):
        tx.place("starter_1", "sk:in", "kit_1_a")
    with (
        pytest.raises(Locked, match="kit_1 is locked by anna"),
        world.transaction("bob", "calls it otherwise", writer=writer) as tx,
    ):
        tx.set("kit_1_b", "rdfs:label", "mine")
    with world.transaction("verify_place", "seen in kit_1_a") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")

    assert world.placement("starter_1").place == "kit_1_a"  # type: ignore[union-attr]


def test_locking_an_unknown_element_is_refused(world: World) -> None:
    with pytest.raises(UsageError, match="nothing to lock by the name of kit_9"):
        world.locks.acquire(["kit_1", "kit_9"], "anna", 60)

    assert world.locks.held() == ()


def test_an_unknown_kind_of_writer_is_refused_before_writing(world: World) -> None:
    with (
        pytest.raises(UsageError, match="one of skill, person, job, system"),
        world.transaction(
            "anna",
            "by hand",
            writer="bogus",  # type: ignore[arg-type]
        ),
    ):
        pytest.fail("the block must not be entered")


def test_author_and_reason_are_reduced_to_one_printable_line(world: World) -> None:
    with world.transaction("an\x1bna\ud800", "first\nline\x00") as tx:
        tx.place("starter_1", "sk:in", "pallet_b")

    assert (world.changes[-1].author, world.changes[-1].reason) == ("an na ", "first line ")


def test_a_subscriber_that_ends_the_program_ends_neither_the_writer_nor_the_others(world: World) -> None:
    told: list[int] = []
    world.subscribe(lambda _: (_ for _ in ()).throw(SystemExit(3)))
    world.subscribe(lambda change: told.append(change.number))

    with world.transaction("anna", "by hand") as tx:
        tx.place("starter_1", "sk:in", "pallet_b")

    assert told == [world.version]
