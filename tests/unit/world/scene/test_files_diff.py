"""Scenes compared, and a live world replaced by a scene."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings

from skiros_py.errors import FileError, Locked
from skiros_py.world.change import Change, ElementEdit, Writer
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import describe, diff, load_scene, save_scene
from skiros_py.world.scene.learned import learned_turtle
from skiros_py.world.undo import undo
from skiros_py.world.world import World

from .worlds import ONTOLOGY, alike, same, worlds

KITTING = Path(__file__).parents[4] / "scenes" / "kitting.ttl"
CARRIED = KITTING.with_name("kitting_carried.ttl")
HEADER = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
scene:floor a sk:Floor .
"""


def scene_of(folder: Path, text: str, name: str = "mine.ttl") -> Path:
    file = folder / name
    file.write_text(HEADER + text, encoding="utf-8")
    return file


def load_into(world: World, path: Path, author: str) -> Change | None:
    """Replaces the scene of a world by that of a file, as one change."""
    wanted = load_scene(world.ontology, path, reasoners=world.reasoners).snapshot()
    with world.transaction(author, f"loaded {path.name}", writer=Writer.PERSON) as tx:
        tx.apply(diff(world.snapshot(), wanted))
        tx.set_source(wanted.source)
    return tx.change


@settings(max_examples=60, deadline=None)
@given(worlds, worlds)
def test_applying_the_diff_of_two_scenes_turns_one_into_the_other(old: World, new: World) -> None:
    learned = learned_turtle(old.snapshot())
    with old.transaction("test", "become the other") as tx:
        tx.apply(diff(old.snapshot(), new.snapshot()))

    assert same(old.snapshot(), new.snapshot())
    assert learned_turtle(old.snapshot()) == learned
    assert diff(old.snapshot(), new.snapshot()) == ()


@settings(max_examples=40, deadline=None)
@given(worlds, worlds)
def test_loading_a_scene_into_a_world_replaces_its_content_and_can_be_undone(world: World, other: World) -> None:
    before = world.snapshot()
    with tempfile.TemporaryDirectory() as folder:
        save_scene(other, Path(folder) / "other.ttl")
        change = load_into(world, Path(folder) / "other.ttl", "anna")

        assert same(world.snapshot(), load_scene(ONTOLOGY, Path(folder) / "other.ttl").snapshot())
    if change is not None:
        assert (change.number, change.author, change.writer) == (world.version, "anna", Writer.PERSON)
        undo(world, "anna")
    assert same(world.snapshot(), before)
    assert all(alike(world.element(n), before.element(n)) for n in before.abstracts("sk:Element"))


def test_loading_an_equal_scene_makes_no_change(world: World) -> None:
    assert diff(world.snapshot(), load_scene(world.ontology, KITTING).snapshot()) == ()
    assert load_into(world, KITTING, "anna") is None
    assert world.version == 1


def test_a_saved_copy_has_no_differences(world: World, tmp_path: Path) -> None:
    save_scene(world, tmp_path / "copy.ttl")

    assert diff(world.snapshot(), load_scene(world.ontology, tmp_path / "copy.ttl").snapshot()) == ()


def test_the_differences_of_two_scenes_are_printed_line_by_line(ontology: Ontology, tmp_path: Path) -> None:
    old = scene_of(
        tmp_path,
        "scene:a a kitting:Starter ; sk:on scene:floor ; sk:mass 1.5 . scene:b a kitting:Kit ; sk:on scene:floor ."
        'scene:this sk:goal "one" .',
    )
    before = load_scene(ontology, old).snapshot()
    new = scene_of(
        tmp_path,
        "scene:a a kitting:Starter ; sk:in scene:c ; sk:mass 2.0 . scene:c a kitting:Kit ; sk:on scene:floor ;"
        ' sk:hasA scene:c_1 . scene:c_1 a kitting:Compartment . scene:this sk:goal "two" .',
    )
    after = load_scene(ontology, new).snapshot()

    assert list(describe(diff(before, after))) == [
        "+ c (kitting:Kit) 'Kit'",
        "+ c_1 (kitting:Compartment) 'Compartment'",
        "~ a sk:mass 1.5 -> 2.0",
        "~ a sk:on floor -> sk:in c",
        "- b sk:on floor",
        "+ c sk:on floor",
        "+ c sk:hasA c_1",
        "- b (kitting:Kit) 'Kit'",
        "- goal one",
        "+ goal two",
    ]


def test_an_element_whose_class_changed_is_removed_and_added_again(ontology: Ontology, tmp_path: Path) -> None:
    guest = "scene:part a kitting:Starter ; sk:in scene:a ."
    world = load_scene(ontology, scene_of(tmp_path, f"scene:a a kitting:Kit ; sk:on scene:floor . {guest}"))
    wanted = scene_of(tmp_path, f"scene:a a kitting:Box ; sk:on scene:floor . {guest}")

    change = load_into(world, wanted, "anna")

    assert change is not None
    edits = [edit for edit in change.edits if isinstance(edit, ElementEdit)]
    assert [(edit.old is None, edit.new is None) for edit in edits] == [(False, True), (True, False)]
    assert (world.instances("kitting:Kit"), world.instances("kitting:Box")) == ((), ("a",))
    assert world.placement("part") == Placement("sk:in", "a")
    json.dumps(change.as_json())


def test_a_replay_of_the_change_gives_the_same_scene(world: World) -> None:
    replayed = world.snapshot().copy()
    change = load_into(world, CARRIED, "anna")

    assert change is not None
    for edit in change.edits:
        replayed.apply(edit)
    assert same(replayed, world.snapshot())


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("scene:a a kitting:Starter ; sk:on scene:floo .", 5, "unknown individual 'floo'"),
        ("scene:a a kitting:Starter .", 5, "is nowhere"),
        ("scene:a a kitting", 5, "not Turtle"),
    ],
)
def test_a_broken_file_changes_nothing_of_a_live_world(
    world: World, tmp_path: Path, text: str, line: int, says: str
) -> None:
    before = world.snapshot()

    with pytest.raises(FileError, match=says) as caught:
        load_into(world, scene_of(tmp_path, text), "anna")

    assert caught.value.line == line
    assert (world.version, world.snapshot()) == (1, before)


def test_a_scene_with_an_element_locked_by_another_author_is_not_replaced(world: World) -> None:
    world.locks.acquire(["kit_1"], "bert", 60.0)

    with pytest.raises(Locked, match="bert"):
        load_into(world, CARRIED, "anna")

    assert world.version == 1
