"""A world that lives in a folder: opened again it is as it was, and what stands in the way is said in words."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.commits import Loss
from skiros_py.config import ontology_paths
from skiros_py.database_file import give_up
from skiros_py.errors import FileError, UnknownName, WorldError
from skiros_py.geometry import Pose
from skiros_py.testing import TINY_ONTOLOGY, tiny_ontology, tiny_scene
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.journal import data_directory
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.journal.journal import Journal
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

Open = Callable[[], DataDirectory]
Weigh = Callable[..., None]


def facts(state: Index) -> object:
    elements = {name: (state.element(name), state.placement(name), state.stamp(name)) for name in state.ids()}
    return elements, list(state.statements()), state.goals


def teach(world: World, label: str = "mug", class_: str = "tiny:Ball") -> str:
    with world.transaction("teacher", f"this is a {label}", writer=Writer.PERSON) as tx:
        return tx.add(class_, label, properties={"sk:mass": 0.25}, learned=True)


# ---------------------------------------------------------------- living on


def test_a_new_directory_begins_with_the_scene(open_tiny: Open, tmp_path: Path) -> None:
    data = open_tiny()

    scene = load_scene(tiny_ontology(), tmp_path / "tiny.ttl")
    assert facts(data.world.snapshot()) == facts(scene.snapshot())
    assert list(data.world.changes) == list(scene.changes)


def test_discarding_the_first_opening_of_a_directory_deletes_its_world(open_tiny: Open, folder: Path) -> None:
    data = open_tiny()
    teach(data.world)
    data.discard()

    assert {file.name for file in folder.iterdir()} <= {"lock"}
    with open_tiny() as again:
        assert again.journal.version == 1


def test_a_kill_at_any_point_of_discarding_hinders_no_later_opening(
    open_tiny: Open, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unlink = Path.unlink
    for point in range(6):
        data, left = open_tiny(), iter(range(point))
        if data.journal.version == 1:
            teach(data.world)

        def killed(file: Path, left: Iterator[int] = left, **options: bool) -> None:
            if (
                file.parent == folder
                and file.name.startswith(("journal.db", "learned.ttl"))
                and next(left, None) is None
            ):
                raise KeyboardInterrupt
            unlink(file, **options)

        with monkeypatch.context() as patched:
            patched.setattr(Path, "unlink", killed)
            with pytest.raises(KeyboardInterrupt):
                data.discard()
        data.close()

        with open_tiny() as again:
            assert again.world.has("ball_1")
        shutil.rmtree(folder)


@pytest.mark.parametrize("what", ["used", "given up"])
def test_files_belong_to_the_owner_of_the_folder_also_if_root_makes_them(
    open_tiny: Open, folder: Path, what: str
) -> None:
    folder.mkdir()
    if os.geteuid() == 0:
        os.chown(folder, 4711, 4711)
    with open_tiny() as data:
        teach(data.world)
    if what == "given up":
        give_up(Loss(folder / "journal.db", (), 1, 10))

    owners = {file.name: (file.stat().st_uid, file.stat().st_gid) for file in folder.iterdir()}

    assert {"journal.db", "journal.db-commits", "learned.ttl", "lock"} <= owners.keys()
    assert set(owners.values()) == {(folder.stat().st_uid, folder.stat().st_gid)}


def test_discarding_a_later_opening_keeps_the_existing_world(open_tiny: Open) -> None:
    with open_tiny() as data:
        mug = teach(data.world)
    open_tiny().discard()

    with open_tiny() as again:
        assert again.world.element(mug).label == "mug"


def test_a_scene_is_loaded_only_into_a_new_directory(
    open_tiny: Open, weigh: Weigh, folder: Path, tmp_path: Path
) -> None:
    with open_tiny() as data:
        weigh(data.world, 5.0)
    other = tmp_path / "other"
    other.mkdir()
    scene = tiny_scene(other, "scene:ball_9 a tiny:Ball ; sk:in scene:box_a .")

    with DataDirectory.open(folder, tiny_ontology(), scene=scene) as data:
        assert data.world.value("ball_1", "sk:mass") == 5.0
        assert not data.world.has("ball_9")


def test_a_reopened_world_is_unchanged(open_tiny: Open) -> None:
    data = open_tiny()
    world = data.world
    world.clock = lambda: 12.5
    with world.transaction("look", "seen") as tx:
        tx.set("ball_1", "sk:pose", Pose.of(0.1, 0.2, 0.3, yaw=1.0))
        tx.set("ball_1", "sk:size", (1.0, 2.5))
        tx.set("ball_1", "sk:missedLooks", 3)
        tx.set("ball_1", "sk:missing", False)
        tx.relate("ball_1", "sk:poseFrame", "box_a")
        tx.relate("robot_1", "tiny:knows", "box_b")
    with world.transaction("pick", "grasped") as tx:
        tx.relate("robot_1", "tiny:carries", "red_ball_1")
        tx.set_goals(["In(ball_1, slot_2)"])
    teach(world)
    before = facts(world.snapshot())
    data.close()

    again = open_tiny().world

    assert facts(again.snapshot()) == before
    assert again.version == 4
    assert again.stamp("ball_1").time == 12.5
    assert again.placement("red_ball_1") == Placement("tiny:carries", "robot_1")


@pytest.mark.parametrize("compacted", [False, True])
def test_ids_are_never_reused(compacted: bool, open_tiny: Open) -> None:
    data = open_tiny()
    place = Placement("sk:in", "box_a")
    with data.world.transaction("delivery", "new") as tx:
        ids = [tx.add("tiny:Ball", placement=place), tx.add("tiny:Ball", id="my_own", placement=place)]
    ids.append(teach(data.world))
    with data.world.transaction("delivery", "taken back") as tx:
        for name in ids:
            tx.remove(name)
    if compacted:
        data.compact(keep=0)
    data.close()

    world = open_tiny().world
    with world.transaction("delivery", "others") as tx:
        others = [tx.add("tiny:Ball", placement=place), tx.add("tiny:Ball", learned=True)]

    assert ids == ["ball_2", "my_own", "learned:ball_1"]
    assert others == ["ball_3", "learned:ball_2"]
    with pytest.raises(WorldError, match="never used again"), world.transaction("x", "y") as tx:
        tx.add("tiny:Ball", id="my_own", placement=place)


def test_after_many_changes_opening_makes_a_snapshot_and_forgets_nothing(
    open_tiny: Open, weigh: Weigh, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data_directory, "_LONG", 10)
    data = open_tiny()
    for n in range(10):
        weigh(data.world, float(n))
    before = facts(data.world.snapshot())
    data.close()

    with open_tiny() as data:
        assert data.journal.since_snapshot == 0
    again = open_tiny()

    assert facts(again.world.snapshot()) == before
    assert [c.number for c in again.world.changes] == list(range(1, 12))


def test_a_directory_opened_without_a_scene_is_empty_and_can_load_one_later(folder: Path, tmp_path: Path) -> None:
    with DataDirectory.open(folder, tiny_ontology()) as data:
        assert data.world.version == 0
        assert not data.world.has("floor")

    with DataDirectory.open(folder, tiny_ontology(), scene=tiny_scene(tmp_path)) as data:
        assert data.world.has("floor")


def test_after_a_broken_scene_the_directory_can_load_a_valid_one(folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.ttl"
    broken.write_text("scene:x", encoding="utf-8")
    with pytest.raises(FileError, match=r"broken\.ttl:1"):
        DataDirectory.open(folder, tiny_ontology(), scene=broken)

    with DataDirectory.open(folder, tiny_ontology(), scene=tiny_scene(tmp_path)) as data:
        assert data.world.has("ball_1")


def test_after_closing_the_world_can_be_read_but_not_written(open_tiny: Open, weigh: Weigh) -> None:
    data = open_tiny()
    data.close()
    data.close()

    assert data.world.has("ball_1")
    with pytest.raises(WorldError, match="the data directory is closed"):
        weigh(data.world, 1.0)
    assert data.world.value("ball_1", "sk:mass") is None


# ---------------------------------------------------------------- what was learned


def test_the_learned_file_is_updated_with_every_change_of_a_learned_concept(open_tiny: Open, folder: Path) -> None:
    data = open_tiny()
    file = folder / "learned.ttl"
    assert not file.exists()

    mug = teach(data.world)
    assert 'rdfs:label "mug"' in file.read_text(encoding="utf-8")

    with data.world.transaction("teacher", "a big one") as tx:
        tx.set(mug, "rdfs:label", "jug")
    assert 'rdfs:label "jug"' in file.read_text(encoding="utf-8")

    with data.world.transaction("teacher", "broken") as tx:
        tx.remove(mug)
    assert "jug" not in file.read_text(encoding="utf-8")


def test_a_copied_learned_file_brings_its_concepts_into_a_new_directory(
    open_tiny: Open, folder: Path, tmp_path: Path
) -> None:
    mug = teach(open_tiny().world)
    text = (folder / "learned.ttl").read_text(encoding="utf-8")
    other = tmp_path / "other"
    other.mkdir()
    (other / "learned.ttl").write_text(text, encoding="utf-8")

    with DataDirectory.open(other, tiny_ontology(), scene=tmp_path / "tiny.ttl") as data:
        assert data.world.element(mug).label == "mug"
        assert [c.author for c in data.world.changes] == ["scene", "learned"]
        assert teach(data.world, "cup") == "learned:ball_2"
    with DataDirectory.open(other, tiny_ontology()) as data:
        assert data.world.element("learned:ball_2").label == "cup"


def test_learned_concepts_are_restored_from_the_journal_and_not_from_the_learned_file(
    open_tiny: Open, folder: Path
) -> None:
    data = open_tiny()
    teach(data.world)
    data.close()
    file = folder / "learned.ttl"
    text = file.read_text(encoding="utf-8")

    for other in ("", "no Turtle", text.replace("mug", "jug")):
        file.write_text(other, encoding="utf-8")
        with open_tiny() as data:
            assert data.world.element("learned:ball_1").label == "mug"
        assert file.read_text(encoding="utf-8") == text
    file.unlink()
    open_tiny().close()
    assert file.read_text(encoding="utf-8") == text


def test_a_learned_file_edited_by_hand_is_backed_up_and_rewritten_with_a_warning(
    open_tiny: Open, folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = open_tiny()
    teach(data.world)
    data.close()
    file = folder / "learned.ttl"
    text = file.read_text(encoding="utf-8")
    open_tiny().close()
    assert not list(folder.glob("learned.ttl.*"))

    for label in ("jug", "cup", "jug"):
        file.write_text(text.replace("mug", label), encoding="utf-8")
        open_tiny().close()

    kept = sorted(folder.glob("learned.ttl.*"))
    assert [path.name for path in kept] == ["learned.ttl.kept-1", "learned.ttl.kept-2"]
    assert [path.read_text(encoding="utf-8") for path in kept] == [text.replace("mug", n) for n in ("jug", "cup")]
    assert file.read_text(encoding="utf-8") == text
    assert "is kept as learned.ttl.kept-1, and written again" in caplog.text
    assert "let it be the learned.ttl of a new data directory" in caplog.text


def test_an_invalid_learned_file_is_refused_before_a_new_directory_is_created(folder: Path, tmp_path: Path) -> None:
    folder.mkdir()
    file = folder / "learned.ttl"
    file.write_text("@prefix learned: <https://w3id.org/skiros-py/learned#> .\nlearned:x a learned:Y .\n")
    with pytest.raises(FileError, match=r"learned\.ttl"):
        DataDirectory.open(folder, tiny_ontology(), scene=tiny_scene(tmp_path))

    assert file.read_text(encoding="utf-8").endswith("learned:x a learned:Y .\n")
    file.unlink()
    with DataDirectory.open(folder, tiny_ontology(), scene=tmp_path / "tiny.ttl") as data:
        assert data.world.version == 1


def test_a_learned_file_that_cannot_be_written_blocks_nothing_and_is_written_later(
    open_tiny: Open, weigh: Weigh, folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = open_tiny()
    file = folder / "learned.ttl"
    file.mkdir()

    teach(data.world)

    assert "learned.ttl is not up to date" in caplog.text
    file.rmdir()
    weigh(data.world, 1.0)
    assert 'rdfs:label "mug"' in file.read_text(encoding="utf-8")


def test_remains_of_the_learned_file_of_a_killed_process_are_removed(open_tiny: Open, folder: Path) -> None:
    folder.mkdir()
    left = folder / ".learned.ttl.0123abcd.tmp"
    left.write_text("half", encoding="utf-8")

    open_tiny()

    assert not left.exists()


# ---------------------------------------------------------------- a second process


def test_opening_a_directory_in_use_names_the_process_that_uses_it(open_tiny: Open, folder: Path) -> None:
    open_tiny()

    with pytest.raises(FileError) as caught:
        DataDirectory.open(folder, tiny_ontology())

    assert str(folder) in str(caught.value)
    assert f"in use by process {os.getpid()} (" in str(caught.value)
    assert " since 2" in str(caught.value)
    assert "stop that first, or choose another folder" in str(caught.value)


OTHER = """
import sys, time
from pathlib import Path
from skiros_py.testing import tiny_ontology
from skiros_py.world.journal.data_directory import DataDirectory
data = DataDirectory.open(Path(sys.argv[1]), tiny_ontology())
print("open", flush=True)
time.sleep(600)
"""


def test_the_directory_of_a_killed_process_can_be_opened(folder: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", OTHER, str(folder)], stdout=subprocess.PIPE, text=True)
    assert other.stdout is not None
    try:
        assert other.stdout.readline() == "open\n"
        with pytest.raises(FileError, match=rf"process {other.pid} \(-c {folder}\)"):
            DataDirectory.open(folder, tiny_ontology())
    finally:
        other.send_signal(signal.SIGKILL)
        other.wait()
        other.stdout.close()

    assert json.loads((folder / "lock").read_text(encoding="utf-8"))["pid"] == other.pid
    DataDirectory.open(folder, tiny_ontology()).close()


def test_a_lock_with_an_unreadable_owner_still_excludes_other_processes(open_tiny: Open, folder: Path) -> None:
    open_tiny()
    (folder / "lock").write_text("?", encoding="utf-8")

    with pytest.raises(FileError, match="in use by another process"):
        DataDirectory.open(folder, tiny_ontology())


def test_a_failed_opening_leaves_nothing_locked(folder: Path) -> None:
    folder.mkdir()
    (folder / "journal.db").write_text("no journal", encoding="utf-8")
    for _ in range(2):
        with pytest.raises(FileError, match="not the journal"):
            DataDirectory.open(folder, tiny_ontology())


# ---------------------------------------------------------------- damage


def damaged(open_tiny: Open, folder: Path) -> str:
    with pytest.raises(FileError) as caught:
        open_tiny()
    assert caught.value.path.parent == folder
    return str(caught.value)


def filled(open_tiny: Open, weigh: Weigh, folder: Path) -> Path:
    with open_tiny() as data:
        for n in range(60):
            weigh(data.world, float(n))
    return folder / "journal.db"


@pytest.mark.parametrize("left", [0, 1, 100, 4096, 0.5, 0.99])
def test_a_truncated_file_is_refused(left: float, open_tiny: Open, weigh: Weigh, folder: Path) -> None:
    file = filled(open_tiny, weigh, folder)
    size = file.stat().st_size
    os.truncate(file, left if isinstance(left, int) else int(left * size))

    assert "journal.db: the file is damaged" in damaged(open_tiny, folder)


@pytest.mark.parametrize("content", [b"no database at all", b"\x00" * 8192, os.urandom(20_000)])
def test_a_file_that_is_not_a_journal_is_refused(content: bytes, open_tiny: Open, folder: Path) -> None:
    folder.mkdir()
    (folder / "journal.db").write_bytes(content)

    assert "the file is damaged, or not the journal of a world" in damaged(open_tiny, folder)


def test_the_database_of_another_program_is_refused_and_left_alone(open_tiny: Open, folder: Path) -> None:
    folder.mkdir()
    with closing(sqlite3.connect(folder / "journal.db")) as connection:
        connection.executescript("CREATE TABLE bookmarks (url TEXT);")
    before = (folder / "journal.db").read_bytes()

    assert "is the file of another program" in damaged(open_tiny, folder)
    assert (folder / "journal.db").read_bytes() == before


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        ("DELETE FROM changes WHERE number = 7", "change 7 is missing"),
        ("DELETE FROM changes WHERE number = 1", "change 1 is missing"),
        ("UPDATE changes SET data = '{' WHERE number = 7", "change 7 cannot be understood"),
        ("UPDATE changes SET data = x'ff' WHERE number = 7", "change 7 cannot be understood"),
        ("UPDATE changes SET data = (SELECT data FROM changes WHERE number = 9) WHERE number = 7", "change 7 is not"),
        ("UPDATE changes SET more = 2 WHERE number = 7", "change 7 is not whole"),
        ("INSERT INTO snapshot VALUES (0, 5, '[', '{}')", "piece 0 of the snapshot cannot be understood"),
        ("INSERT INTO snapshot VALUES (0, 5, '[]', '[1]')", "piece 0 of the snapshot cannot be understood"),
        ("INSERT INTO snapshot VALUES (0, 5, '[]', '{}'), (2, 5, '[]', '{}')", "piece 1 of the snapshot"),
        ("INSERT INTO snapshot VALUES (0, 5, '[]', '{}')", "change 6 is about 'ball_1', which was not there"),
    ],
)
def test_a_damaged_journal_is_refused_with_the_damaged_part(
    damage: str, reason: str, open_tiny: Open, weigh: Weigh, folder: Path
) -> None:
    with closing(sqlite3.connect(filled(open_tiny, weigh, folder))) as connection:
        connection.execute(damage)
        connection.commit()

    assert reason in damaged(open_tiny, folder)


def test_a_log_without_its_file_is_refused(open_tiny: Open, folder: Path) -> None:
    folder.mkdir()
    (folder / "journal.db-wal").write_bytes(b"what is left")

    assert "the file is missing, but journal.db-wal exists" in damaged(open_tiny, folder)


# ---------------------------------------------------------------- folders


def test_a_path_that_is_not_a_folder_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("mine", encoding="utf-8")

    with pytest.raises(FileError, match="is not a folder"):
        DataDirectory.open(file, tiny_ontology())
    with pytest.raises(FileError, match="cannot be made"):
        DataDirectory.open(file / "below", tiny_ontology())
    assert file.read_text(encoding="utf-8") == "mine"


def test_a_folder_without_write_permission_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"cannot be (made|opened)"):
        DataDirectory.open(Path("/proc/self/fdinfo"), tiny_ontology())
    (tmp_path / "lock").mkdir()
    with pytest.raises(FileError, match="lock: cannot be opened"):
        DataDirectory.open(tmp_path, tiny_ontology())
    (tmp_path / "lock").rmdir()
    (tmp_path / "journal.db").mkdir()
    with pytest.raises(FileError, match="journal"):
        DataDirectory.open(tmp_path, tiny_ontology())


def test_a_missing_folder_is_not_created_unless_requested(folder: Path) -> None:
    with pytest.raises(FileError, match="is no data directory"):
        DataDirectory.open(folder, tiny_ontology(), create=False)

    assert not folder.exists()


# ---------------------------------------------------------------- another ontology


CORE = ontology_paths()[0] / "core.ttl"


def other_ontology(folder: Path, *replacements: tuple[str, str]) -> Ontology:
    text = TINY_ONTOLOGY.read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    (folder / "other.ttl").write_text(text, encoding="utf-8")
    return Ontology.load([CORE, folder / "other.ttl"])


@pytest.mark.parametrize(
    ("old", "new", "reasons"),
    [
        ("tiny:RedBall", "tiny:BlueBall", ["unknown class 'tiny:RedBall'"]),
        ("tiny:knows", "tiny:visited", ["unknown relation 'tiny:knows'"]),
        ("tiny:carries", "tiny:brings", ["unknown relation 'tiny:carries'"]),
        ("tiny:colour", "tiny:paint", ["unknown property 'tiny:colour'"]),
        ("tiny:Ball ; rdfs:range xsd:string", "tiny:Ball ; rdfs:range xsd:integer",
         ["tiny:colour is a xsd:integer now", "'red'"]),
        ("tiny:knows a owl:ObjectProperty", "tiny:knows rdfs:subPropertyOf sk:computed ; a owl:ObjectProperty",
         ["tiny:knows is stored as a plain relation, and is a computed relation now"]),
    ],
)  # fmt: skip
def test_a_journal_is_refused_with_the_terms_that_the_ontology_no_longer_declares(
    old: str, new: str, reasons: list[str], folder: Path, tmp_path: Path
) -> None:
    colour = "tiny:colour a owl:DatatypeProperty ; rdfs:domain tiny:Ball ; rdfs:range xsd:string ."
    declared = ("\n\n", f"\n@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .\n{colour}\n")
    rich = TINY_ONTOLOGY.read_text(encoding="utf-8").replace(*declared, 1)
    (tmp_path / "rich.ttl").write_text(rich, encoding="utf-8")
    (tmp_path / "other.ttl").write_text(rich.replace(old, new), encoding="utf-8")
    assert rich != rich.replace(old, new)
    fitting = Ontology.load([CORE, tmp_path / "rich.ttl"])
    with (
        DataDirectory.open(folder, fitting, scene=tiny_scene(tmp_path)) as data,
        data.world.transaction("a", "b") as tx,
    ):
        tx.relate("robot_1", "tiny:knows", "box_a")
        tx.relate("robot_1", "tiny:carries", "ball_1")
        tx.set("ball_1", "tiny:colour", "red")

    with pytest.raises(FileError) as caught:
        DataDirectory.open(folder, Ontology.load([CORE, tmp_path / "other.ttl"]))

    assert "does not fit the ontology" in str(caught.value)
    for reason in reasons:
        assert reason in str(caught.value)
    DataDirectory.open(folder, fitting).close()


def test_terms_used_only_by_past_changes_need_not_be_declared(open_tiny: Open, folder: Path, tmp_path: Path) -> None:
    with open_tiny() as data, data.world.transaction("ann", "no red balls") as tx:
        tx.remove("red_ball_1")

    with DataDirectory.open(folder, other_ontology(tmp_path, ("tiny:RedBall", "tiny:BlueBall"))) as data:
        assert not data.world.has("red_ball_1")
        assert data.journal.history("red_ball_1")[0].change.author == "scene"


def test_individuals_of_the_ontology_come_from_the_ontology(folder: Path, tmp_path: Path) -> None:
    scene = tiny_scene(tmp_path)
    ball = ("tiny:Giant a owl:Class", "tiny:model_ball a tiny:Ball .\ntiny:Giant a owl:Class")
    with DataDirectory.open(folder, other_ontology(tmp_path, ball), scene=scene) as data:
        data.compact(keep=0)

    with DataDirectory.open(folder, tiny_ontology()) as data, pytest.raises(UnknownName):
        data.world.element("tiny:model_ball")


def test_a_world_can_use_a_journal_as_its_log(tmp_path: Path) -> None:
    with closing(Journal(tmp_path / "own.db")) as journal:
        world = World(tiny_ontology(), past=journal.past(Index(tiny_ontology())))
        with world.transaction("ann", "a floor") as tx:
            tx.add("sk:Floor", id="floor")
        assert world.log is journal
    with closing(Journal(tmp_path / "own.db")) as journal:
        assert World(tiny_ontology(), past=journal.past(Index(tiny_ontology()))).has("floor")
