"""Worlds of any size for planning: parts in boxes, kits on tables, robots."""

from __future__ import annotations

from skiros_py.config import find_scene, ontology_paths
from skiros_py.planning.problem.task import Capability
from skiros_py.world.element import Placement
from skiros_py.world.ontology import load_installed
from skiros_py.world.reasoners.registry import load_reasoners
from skiros_py.world.scene.files import load_scene
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ARM, AT, BASE, CAMERA, DRIVING_POSE, GRIPPER, HAS_A, IN, MAX_GAP, ON, ROBOT
from skiros_py.world.world import World
from skiros_skills import kitting
from skiros_skills.drive import DESCRIPTION as DRIVE
from skiros_skills.pick import DESCRIPTION as PICK
from skiros_skills.place import DESCRIPTION as PLACE

PART_CLASSES = (kitting.STARTER, kitting.ALTERNATOR, kitting.COMPRESSOR, kitting.RELAY_BOX)
"""Classes of the parts, in turn."""


def kitting_world() -> World:
    """Returns the world of the scene ``kitting``."""
    paths = ontology_paths()
    ontology, _ = load_installed(paths)
    reasoners, _ = load_reasoners(ontology)
    return load_scene(ontology, find_scene("kitting"), paths, reasoners=reasoners)


def able(view: WorldView) -> list[Capability]:
    """Returns drive, pick and place for every robot."""
    return [Capability(skill, view.instances(skill.agent_class)) for skill in (DRIVE, PICK, PLACE)]


def crowded(*, parts: int = 0, boxes: int = 0, kits: int = 0, robots: int = 1, others: int = 0) -> World:
    """Returns the world of the scene ``kitting`` with additional elements.

    Args:
        parts: How many more parts there are, of all classes in turn, spread over the boxes.
        boxes: How many more storage places there are.
        kits: How many more kits of four compartments.
        robots: How many robots in all.
        others: How many more things that no skill is about.
    """
    world = kitting_world()
    with world.transaction("benchmark", "a crowded world") as tx:
        pallets = [tx.add(kitting.PALLET, placement=Placement(ON, "floor")) for _ in range(boxes)]
        for number in range(parts):
            box = pallets[number // len(PART_CLASSES) % boxes] if boxes else "pallet_a"
            tx.add(PART_CLASSES[number % len(PART_CLASSES)], placement=Placement(IN, box))
        for _ in range(kits):
            _add_kit(tx)
        for _ in range(robots - 1):
            _add_robot(tx, world)
        for _ in range(others):
            tx.add(kitting.RACK, placement=Placement(ON, "floor"))
    return world


def _add_kit(tx: Transaction) -> None:
    kit = tx.add(kitting.KIT, placement=Placement(ON, "kit_table"))
    tx.set(kit, DRIVING_POSE, tx.view.value("kit_1", DRIVING_POSE))
    for letter in "abcd":
        tx.relate(kit, HAS_A, tx.add(kitting.COMPARTMENT, id=f"{kit}_{letter}"))


def _add_robot(tx: Transaction, view: WorldView) -> None:
    robot = tx.add(ROBOT, placement=Placement(AT, "unknown_location"))
    base, arm, gripper, camera = (tx.add(class_) for class_ in (BASE, ARM, GRIPPER, CAMERA))
    tx.set(gripper, MAX_GAP, view.value("gripper_1", MAX_GAP))
    for whole, part in ((robot, base), (robot, arm), (arm, gripper), (arm, camera)):
        tx.relate(whole, HAS_A, part)
