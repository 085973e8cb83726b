"""What a journal remembers, and what it does when it cannot."""

from __future__ import annotations

import resource
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from skiros_py.errors import DiskFault, FileError, UsageError, WorldError
from skiros_py.testing import tiny_ontology, tiny_world
from skiros_py.world.change import Change, ElementEdit, GoalsEdit, PropertyEdit, Writer
from skiros_py.world.index import Index
from skiros_py.world.journal import journal as journal_module
from skiros_py.world.journal import records
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.journal.journal import Journal
from skiros_py.world.journal.records import SCHEMA, Entry, encode_change
from skiros_py.world.past import GOALS, MemoryLog

Open = Callable[[], DataDirectory]
Weigh = Callable[..., None]


def change(number: int, element: str = "ball_1", **more: object) -> Change:
    edit = PropertyEdit(element, "sk:mass", float(number - 1), float(number))
    return Change(number, "weigh", f"reason {number}", number / 10, (edit,), **more)  # type: ignore[arg-type]


@pytest.fixture
def journal(tmp_path: Path) -> Iterator[Journal]:
    with closing(Journal(tmp_path / "journal.db")) as opened:
        yield opened


@contextmanager
def small_disk(limit: int) -> Iterator[None]:
    """No file can grow beyond the limit [bytes]."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


# ---------------------------------------------------------------- remembering


def test_changes_are_kept_in_order_when_the_file_is_opened_again(tmp_path: Path) -> None:
    changes = [change(n) for n in range(1, 6)]
    with closing(Journal(tmp_path / "journal.db")) as journal:
        for one in changes:
            journal.append(one)

    with closing(Journal(tmp_path / "journal.db")) as journal:
        assert (journal.first, journal.version) == (1, 5)
        assert list(journal.since(0)) == changes
        assert list(journal.since(3)) == changes[3:]
        assert list(journal.since(5)) == []


def test_recent_changes_are_kept_in_memory_and_older_changes_are_read_from_the_file(
    journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_module, "_MOST_CHANGES", 3)
    monkeypatch.setattr(records, "_AT_ONCE", 2)
    changes = [change(n) for n in range(1, 10)]
    for one in changes:
        journal.append(one)

    assert len(journal._recent) == 3
    for version in range(10):
        assert list(journal.since(version)) == changes[version:]


def test_a_huge_change_displaces_other_changes_from_memory(journal: Journal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_module, "_MOST_EDITS", 5)
    huge = Change(4, "scene", "load", 0.0, tuple(change(1, f"ball_{n}").edits[0] for n in range(100)))
    for one in (change(1), change(2), change(3), huge):
        journal.append(one)

    assert len(journal._recent) == 1
    assert list(journal.since(2)) == [change(3), huge]


def test_a_change_split_over_several_rows_is_read_back_complete(journal: Journal, tmp_path: Path) -> None:
    huge = Change(1, "scene", "load", 0.0, tuple(change(n, f"ball_{n}").edits[0] for n in range(2500)))
    journal.append(huge)
    journal.close()

    with closing(Journal(tmp_path / "journal.db")) as again:
        assert list(again.since(0)) == [huge]
        assert [entry.change.number for entry in again.history("ball_2400")] == [1]


def test_each_change_is_stored_with_its_wall_clock_time(journal: Journal) -> None:
    before = time.time()
    journal.append(change(1))

    (entry,) = journal.history()

    assert before <= entry.wall <= time.time()
    assert "wall" not in entry.change.as_json()


def test_the_history_of_an_element_is_every_change_that_touched_it(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    weigh(data.world, 1.0)
    weigh(data.world, 2.0, "red_ball_1")
    with data.world.transaction("ann", "not needed any more", writer=Writer.PERSON) as tx:
        tx.remove("ball_1")

    entries = data.journal.history("ball_1")

    assert [(e.change.number, e.change.author, e.change.reason) for e in entries] == [
        (1, "scene", "read from tiny.ttl"),
        (2, "weigh", "1.0 kg"),
        (4, "ann", "not needed any more"),
    ]
    assert data.journal.history("ball_1", last=1) == entries[-1:]
    assert data.journal.history("slot_1") == entries[:1]
    assert data.journal.history("nothing_1") == ()
    assert [e.change.number for e in data.journal.history()] == [1, 2, 3, 4]
    assert data.journal.was_given("ball_1")
    assert not data.journal.was_given("nothing_1")


def test_changes_of_elements_are_found_as_in_a_list_in_memory(journal: Journal) -> None:
    memory = MemoryLog()
    for n in range(1, 40):
        goals = (GoalsEdit((), ("x",)),) if n % 7 == 0 else ()
        one = change(n, f"ball_{n % 5}", writer=Writer.PERSON if n % 3 else Writer.SKILL, undoes=4 if n == 9 else None)
        one = Change(n, one.author, one.reason, one.time, (*one.edits, *goals), one.writer, one.undoes)
        memory.append(one)
        journal.append(one)

    for subjects in (["ball_1"], ["ball_0", "ball_4"], [GOALS], [GOALS, "ball_2"], ["none"], []):
        for after in (0, 13, 39):
            assert list(journal.about(subjects, after)) == list(memory.about(subjects, after))
    assert journal.undoable() == memory.undoable() is not None


# ---------------------------------------------------------------- failing


def test_on_a_full_disk_a_persons_change_is_refused_and_the_next_one_is_accepted(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    world, log = data.world, data.path / "journal.db-wal"
    weigh(world, 1.0)
    seen: list[int] = []
    world.subscribe(lambda c: seen.append(c.number))
    before = world.snapshot()

    with (
        small_disk(log.stat().st_size + 1000),
        pytest.raises(FileError, match=r"the disk|room"),
        world.transaction("ann", "weighed by hand", writer=Writer.PERSON) as tx,
    ):
        tx.set("ball_1", "sk:mass", 2.0)

    assert world.snapshot() == before
    assert seen == []
    assert world.value("ball_1", "sk:mass") == 1.0
    weigh(world, 3.0)
    data.close()
    assert [c.number for c in open_tiny().world.changes] == [1, 2, 3]


def test_on_a_full_disk_what_a_skill_sensed_waits_in_memory_and_is_stored_first_afterwards(
    open_tiny: Open, weigh: Weigh
) -> None:
    data = open_tiny()
    world, log = data.world, data.path / "journal.db-wal"
    weigh(world, 1.0)
    with small_disk(log.stat().st_size + 1000):
        weigh(world, 2.0)
        weigh(world, 3.0)
        assert world.value("ball_1", "sk:mass") == 3.0
        assert [one.number for one in world.changes] == [1, 2, 3, 4]
        assert [one.number for one in data.journal.about(["ball_1"], 2)] == [3, 4]
    weigh(world, 4.0)
    data.close()

    with open_tiny() as again:
        assert [one.number for one in again.world.changes] == [1, 2, 3, 4, 5]
        assert again.world.value("ball_1", "sk:mass") == 4.0


def test_closing_on_a_full_disk_names_the_changes_that_are_lost(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    log = data.path / "journal.db-wal"
    with small_disk(log.stat().st_size + 1000):
        weigh(data.world, 2.0)
        with pytest.raises(DiskFault, match=r"the last changes \(2 to 2\) are lost"):
            data.close()

    with open_tiny() as again:
        assert again.world.version == 1


def test_a_change_refused_for_a_full_disk_names_the_full_disk(open_tiny: Open) -> None:
    data = open_tiny()
    connection = data.journal._database._connection
    assert connection is not None
    (pages,) = connection.execute("PRAGMA page_count").fetchone()
    connection.execute(f"PRAGMA max_page_count = {pages}")
    before = data.world.snapshot()

    with (
        pytest.raises(FileError, match=r"journal\.db: the disk is full: nothing was changed"),
        data.world.transaction("ann", "a long text", writer=Writer.PERSON) as tx,
    ):
        tx.set("ball_1", "rdfs:label", "x" * 60_000)

    assert data.world.snapshot() == before
    assert data.journal.history("ball_1")[-1].change.number == 1


def test_on_a_full_disk_compaction_is_refused_and_all_changes_are_kept(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    for n in range(50):
        weigh(data.world, float(n))

    with small_disk((data.path / "journal.db-wal").stat().st_size + 100), pytest.raises(FileError):
        data.compact(keep=0)

    assert (data.journal.first, data.journal.version) == (1, 51)
    data.close()
    assert len(open_tiny().world.changes) == 51


def test_a_change_interrupted_before_its_publication_is_replaced_by_the_next_change(journal: Journal) -> None:
    journal.append(change(1))
    journal._remember = lambda _: exec("raise KeyboardInterrupt")  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        journal.append(change(2))
    del journal._remember  # type: ignore[method-assign]

    other = Change(2, "pick", "instead", 0.0, change(2).edits)
    journal.append(other)

    assert list(journal.since(0)) == [change(1), other]
    assert [entry.change for entry in journal.history("ball_1")] == [change(1), other]


# ---------------------------------------------------------------- compaction


def test_compaction_keeps_the_state_and_reading_a_deleted_change_is_refused(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    for n in range(20):
        weigh(data.world, float(n))
    before = facts(data.world.snapshot())

    data.compact(keep=5)

    assert (data.journal.first, data.journal.version) == (17, 21)
    assert [c.number for c in data.world.changes] == [17, 18, 19, 20, 21]
    assert [c.number for c in data.world.changes_since(16)] == [17, 18, 19, 20, 21]
    with pytest.raises(WorldError, match="compacted and begins with change 17"):
        data.world.changes_since(15)
    data.close()
    again = open_tiny()
    assert facts(again.world.snapshot()) == before
    assert (again.journal.first, again.world.version) == (17, 21)


def test_change_numbers_continue_after_all_changes_were_compacted(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    weigh(data.world, 1.0)
    data.compact(keep=0)
    assert list(data.world.changes) == []
    data.close()

    again = open_tiny()
    weigh(again.world, 2.0)

    assert [c.number for c in again.world.changes] == [3]
    assert again.world.stamp("slot_1").change == 1


def test_compaction_frees_disk_space(open_tiny: Open) -> None:
    data = open_tiny()
    for n in range(200):
        with data.world.transaction("ann", "a long text") as tx:
            tx.set("ball_1", "rdfs:label", f"{n}" * 2000)
    data.compact(keep=200)
    long = (data.path / "journal.db").stat().st_size

    data.compact(keep=1)

    assert (data.path / "journal.db").stat().st_size < long / 5


def test_compaction_refuses_a_negative_number_of_changes(open_tiny: Open) -> None:
    with pytest.raises(UsageError, match="not -1"):
        open_tiny().compact(keep=-1)


def test_threads_can_read_the_journal_during_writing_and_compaction(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    faults: list[BaseException] = []
    done = threading.Event()

    def ask() -> None:
        try:
            while not done.is_set():
                version = data.world.version
                later = data.journal.history("ball_1", last=3)
                assert [e.change.number for e in later] == sorted(e.change.number for e in later)
                assert all(c.number > version for c in data.world.changes_since(version))
        except BaseException as error:  # noqa: BLE001
            faults.append(error)

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    for n in range(300):
        weigh(data.world, float(n))
        if n % 100 == 99:
            data.compact(keep=250)
    done.set()
    for thread in threads:
        thread.join()

    assert faults == []
    assert data.journal.version == 301


# ---------------------------------------------------------------- versions of the tables


@pytest.mark.parametrize("longest", [1000, 4])
def test_a_file_of_version_one_is_upgraded_with_its_content(
    longest: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(records, "LONGEST_PART", longest)
    world = tiny_world()
    with world.transaction("ann", "goals", writer=Writer.PERSON) as tx:
        tx.set_goals(["In(ball_1, slot_1)"])
        tx.set("ball_1", "sk:mass", 2.0)
    old = old_file(tmp_path / "journal.db", world.changes)

    with closing(Journal(old)) as journal:
        assert list(journal.since(0)) == list(world.changes)
        assert [e.change.number for e in journal.history("ball_1")] == [1, 2]
        assert [e.change.number for e in journal.history("gripper_1")] == [1]  # it ends a relation
        assert [c.number for c in journal.about([GOALS], 0)] == [2]
        past = journal.past(Index(tiny_ontology()))
    assert facts(past.index) == facts(world.snapshot())
    assert past.ids.used("ball_1")
    with closing(sqlite3.connect(old)) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (len(SCHEMA.migrations),)
        marked = set(connection.execute("SELECT * FROM marks"))
    fresh = tmp_path / "fresh.db"
    with closing(Journal(fresh)) as journal:
        journal.append_all(world.changes)
    with closing(sqlite3.connect(fresh)) as connection:
        assert set(connection.execute("SELECT * FROM marks")) == marked


def test_a_failed_upgrade_leaves_the_file_unchanged(tmp_path: Path) -> None:
    old = old_file(tmp_path / "journal.db", tiny_world().changes)
    with closing(sqlite3.connect(old)) as connection:
        connection.execute("UPDATE changes SET data = 'no JSON'")
        connection.commit()

    with pytest.raises(FileError, match=r"journal\.db"):
        Journal(old)

    with closing(sqlite3.connect(old)) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (1,)
        assert connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'marks'").fetchone() == (0,)


def test_a_file_of_a_later_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    Journal(path).close()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version = 99")

    with pytest.raises(FileError, match=r"version 99.*supports versions up to 3.*a later one"):
        Journal(path)


def old_file(path: Path, changes: Sequence[Change]) -> Path:
    """Writes a file as the first version of this program did."""
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(SCHEMA.migrations[0])
        connection.executescript(f"PRAGMA application_id = {SCHEMA.application}; PRAGMA user_version = 1;")
        for one in changes:
            text, *more = encode_change(one)
            row = (one.number, 1.5e9, one.writer.value, one.undoes, len(more), text)
            connection.execute("INSERT INTO changes VALUES (?, ?, ?, ?, ?, ?)", row)
            connection.executemany(
                "INSERT INTO more_edits VALUES (?, ?, ?)", [(one.number, n, t) for n, t in enumerate(more)]
            )
            given = [(edit.element,) for edit in one.edits if isinstance(edit, ElementEdit) and edit.new]
            connection.executemany("INSERT OR IGNORE INTO given_ids VALUES (?)", given)
        connection.commit()
    return path


def facts(state: Index) -> object:
    elements = {name: (state.element(name), state.placement(name), state.stamp(name)) for name in state.ids()}
    return elements, list(state.statements()), state.goals


def numbers(heads: Sequence[Entry]) -> list[int]:
    return [head.change.number for head in heads]


def test_pages_are_read_forward_after_a_number_or_backward_before_it(journal: Journal) -> None:
    journal.append_all([change(number, element=f"ball_{number % 2}") for number in range(1, 8)])

    assert numbers(journal.page(0, 3)) == [1, 2, 3]
    assert numbers(journal.page(3, 10)) == [4, 5, 6, 7]
    assert numbers(journal.page(8, 3, newest_first=True)) == [7, 6, 5]
    assert numbers(journal.page(1, 2, element="ball_1")) == [3, 5]
    assert numbers(journal.page(5, 9, element="ball_1", newest_first=True)) == [3, 1]


@pytest.mark.parametrize("total", [0, 1, 999, 1000, 1001, 2000, 2500])
def test_any_range_of_edits_of_a_long_change_can_be_read_alone(journal: Journal, total: int) -> None:
    edits = tuple(PropertyEdit(f"ball_{n}", "sk:mass", None, float(n)) for n in range(total))
    journal.append(Change(1, "scene", "loaded", 0.0, edits))

    (head,) = journal.page(0, 1)

    assert (head.edits, head.change.edits) == (total, edits[:1000])
    for start, most in ((0, 10), (990, 20), (1000, 1000), (995, 1400), (2400, 500), (3000, 5)):
        assert journal.edits(head, start, most) == edits[start : start + most]


def test_the_undoable_change_is_the_last_change_by_a_person_that_was_not_undone(journal: Journal) -> None:
    assert journal.undoable_entry() is None
    for number, more in enumerate(
        [{"writer": Writer.PERSON}, {}, {"writer": Writer.PERSON}, {"writer": Writer.PERSON, "undoes": 3}], start=1
    ):
        journal.append(change(number, **more))

    head = journal.undoable_entry()

    assert head is not None
    assert head.change == journal.undoable()
    assert head.change.number == 1
