"""The digest of a run takes in whatever thread tells it something."""

from __future__ import annotations

import threading

from skiros_py.execution.runtime import RunDigest
from skiros_py.testing import tiny_world


def test_equal_runs_have_equal_digests_and_different_runs_have_different_ones() -> None:
    one, other, different = RunDigest(), RunDigest(), RunDigest()
    for digest, state in ((one, b"a"), (other, b"a"), (different, b"b")):
        digest.begin(b"start")
        digest.add(state)

    assert str(one) == str(other) != str(different)


def test_events_before_a_run_do_not_change_its_digest() -> None:
    one, other = RunDigest(), RunDigest()
    one.add(b"an earlier run")
    one.begin(b"start")
    other.begin(b"start")

    assert str(one) == str(other)


def test_a_world_change_changes_the_digest() -> None:
    digest, world = RunDigest(), tiny_world()
    before = str(digest)
    world.subscribe(digest.add_change)
    with world.transaction("test", "it was moved") as tx:
        tx.place("robot_1", "sk:at", "box_b")

    assert str(digest) != before


def test_no_data_added_by_concurrent_threads_is_lost_from_the_digest() -> None:
    """Equal pieces make the same digest in any order, if none is lost or torn."""
    digest, alone = RunDigest(), RunDigest()
    piece = b"x" * 4096  # long enough that hashing lets other threads run

    def tell() -> None:
        for _ in range(500):
            digest.add(piece)

    threads = [threading.Thread(target=tell) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for _ in range(2000):
        alone.add(piece)

    assert str(digest) == str(alone)
