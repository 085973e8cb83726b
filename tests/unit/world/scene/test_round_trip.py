"""A scene saved is the scene loaded, whatever is in it, and what was learned likewise."""

from __future__ import annotations

import tempfile
from pathlib import Path
from random import Random

import rdflib
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.world.element import Placement
from skiros_py.world.scene.files import load_scene, save_scene
from skiros_py.world.scene.learned import learned_turtle, read_learned
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.world import World

from .worlds import ONTOLOGY, Step, alike, goals, learned_steps, made, poses, same, scene_steps, worlds


def saved_and_loaded(world: World) -> World:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.ttl"
        save_scene(world, file)
        return load_scene(ONTOLOGY, file)


@settings(max_examples=80, deadline=None)
@given(worlds)
def test_a_saved_and_reloaded_scene_is_equal_without_learned_concepts(world: World) -> None:
    again = saved_and_loaded(world)

    assert same(world.snapshot(), again.snapshot())
    assert not [name for name in again.abstracts("sk:Element") if name.startswith("learned:")]


@settings(max_examples=40, deadline=None)
@given(worlds)
def test_saving_a_loaded_scene_gives_the_same_text(world: World) -> None:
    again = saved_and_loaded(world)

    assert scene_turtle(again.snapshot()) == scene_turtle(saved_and_loaded(again).snapshot())


@settings(max_examples=30, deadline=None)
@given(st.randoms(use_true_random=False), st.lists(scene_steps, max_size=6), goals)
def test_the_text_depends_on_the_content_alone(random: Random, steps: list[Step], goals: list[str]) -> None:
    world = made(steps, goals)
    names = list(world.instances("sk:Element"))
    random.shuffle(names)
    other = World(ONTOLOGY)
    with other.transaction("test", "in another order") as tx:
        for name in names:
            element = world.element(name)
            backwards = dict(reversed(list(element.properties.items())))
            tx.add(element.type, element.label, name, backwards)
        for subject, relation, object_ in reversed([s for s in world.snapshot().statements() if ":" not in s[0]]):
            tx.relate(subject, relation, object_)
        tx.set_goals(reversed(goals))

    assert scene_turtle(other.snapshot()) == scene_turtle(world.snapshot())


@settings(max_examples=30, deadline=None)
@given(worlds)
def test_rdflib_reads_the_same_statements_from_a_saved_scene(world: World) -> None:
    text = scene_turtle(world.snapshot())
    graph = rdflib.Graph().parse(data=text, format="turtle")
    labels = {str(s).rpartition("#")[2]: str(o) for s, o in graph.subject_objects(rdflib.RDFS.label)}

    assert labels == {name: world.element(name).label for name in world.instances("sk:Element")}
    assert len(graph) == sum(line.endswith(" ;") for line in text.split("\n"))


@settings(max_examples=40, deadline=None)
@given(st.lists(scene_steps | learned_steps, max_size=6))
def test_learned_concepts_are_read_as_they_were_written(steps: list[Step]) -> None:
    world = made(steps, [])
    text = learned_turtle(world.snapshot())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "learned.ttl"
        file.write_text(text, encoding="utf-8")
        again = read_learned(ONTOLOGY, file)

    assert again.abstracts("sk:Element") == world.abstracts("sk:Element")
    assert all(alike(world.element(name), again.element(name)) for name in world.abstracts("sk:Element"))
    assert learned_turtle(again.snapshot()) == text
    assert again.instances("sk:Element") == ()


@settings(max_examples=100, deadline=None)
@given(poses, st.sampled_from([Pose(orientation=(0.0, -(0.5**0.5), 0.0, -(0.5**0.5))), Pose()]))
def test_every_orientation_survives(pose: Pose, turn: Pose) -> None:
    world = World(ONTOLOGY)
    with world.transaction("test", "one part") as tx:
        tx.add("sk:Floor", id="floor")
        tx.add("kitting:Starter", id="a", properties={"sk:pose": turn @ pose}, placement=Placement("sk:on", "floor"))

    assert same(world.snapshot(), saved_and_loaded(world).snapshot())


def test_each_added_statement_adds_one_line_to_the_saved_scene(tmp_path: Path) -> None:
    world = load_scene(ONTOLOGY, Path(__file__).parents[4] / "scenes" / "kitting.ttl")
    before = scene_turtle(world.snapshot()).splitlines()
    with world.transaction("look", "seen") as tx:
        tx.set("starter_1", "sk:missing", True)
        tx.relate("starter_1", "sk:poseFrame", "pallet_a")
    after = scene_turtle(world.snapshot()).splitlines()

    assert [line for line in after if line not in before] == [
        "    sk:poseFrame scene:pallet_a ;",
        "    sk:missing true ;",
    ]
    at = after.index("    sk:poseFrame scene:pallet_a ;")
    assert after[:at] + after[at + 2 :] == before
