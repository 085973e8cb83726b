"""Random worlds of the shipped ontologies."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[4] / "ontologies"])
PLACES = ("kitting:Box", "kitting:Pallet", "kitting:Kit", "sk:Station", "kitting:Table")
PARTS = ("kitting:Starter", "kitting:Alternator", "sk:Manipulatable")

_angles = st.sampled_from([0.0, math.pi, -math.pi, math.pi / 2, -math.pi / 2]) | st.floats(-4, 4)
_lengths = st.floats(-1e6, 1e6)
poses = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose.of(x, y, z, roll=roll, pitch=pitch, yaw=yaw),
    *(_lengths, _lengths, _lengths, _angles, _angles, _angles),
)
texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=30)
labels = texts.filter(bool) | st.sampled_from(
    [
        '"',
        "'''",
        "\\",
        "a\r\nb",
        "\u2028",
        "\x00",
        "?s ?p ?o } ; DROP ALL",
        "scene:floor .",
        "# not a comment",
        "\ufeff",
    ]
)
_values: dict[str, st.SearchStrategy[Value]] = {
    "sk:pose": poses,
    "sk:size": st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=4).map(tuple),
    "sk:mass": st.floats(allow_nan=False, allow_infinity=False),
    "sk:missing": st.booleans(),
    "rdfs:comment": texts,
}
_properties = st.fixed_dictionaries({}, optional=_values)
_numbers = st.integers(0, 5)

Step = Callable[[Transaction, list[str]], None]


def _add(class_: str, label: str, properties: dict[str, Value], relation: str, place: int) -> Step:
    def step(tx: Transaction, places: list[str]) -> None:
        name = tx.add(class_, label, None, properties, Placement(relation, places[place % len(places)]))
        if class_ in PLACES:
            places.append(name)

    return step


def _add_piece(label: str, properties: dict[str, Value], owner: int, frame: int) -> Step:
    def step(tx: Transaction, places: list[str]) -> None:
        name = tx.add("kitting:Compartment", label, None, properties)
        tx.relate(places[owner % len(places)], "sk:hasA", name)
        tx.relate(name, "sk:poseFrame", places[frame % len(places)])

    return step


def _teach(label: str, properties: dict[str, Value]) -> Step:
    def step(tx: Transaction, places: list[str]) -> None:
        whole = tx.add("kitting:Kit", label, None, {**properties, "sk:appliesTo": "kitting:Kit"}, learned=True)
        tx.relate(whole, "sk:hasA", tx.add("kitting:Compartment", label, learned=True))

    return step


scene_steps = st.one_of(
    st.builds(
        _add, st.sampled_from(PLACES + PARTS), labels, _properties, st.sampled_from(["sk:in", "sk:on"]), _numbers
    ),
    st.builds(_add_piece, labels, _properties, _numbers, _numbers),
)
learned_steps = st.builds(_teach, labels, _properties)
goals = st.lists(labels.filter(lambda text: bool(text.strip())), max_size=3)


def made(steps: list[Step], goals: list[str]) -> World:
    """Returns a world in which the steps were done."""
    world = World(ONTOLOGY)
    with world.transaction("test", "random") as tx:
        places = [tx.add("sk:Floor", id="floor")]
        for step in steps:
            step(tx, places)
        tx.set_goals(goals)
    return world


worlds = st.builds(made, st.lists(scene_steps | learned_steps, max_size=8), goals)


def same(one: Index, other: Index, class_: str = "sk:Element") -> bool:
    """Returns True where both scenes say the same; of poses, what a file says to 1e-9."""
    names = one.instances(class_)
    return (
        names == other.instances(class_)
        and one.goals == other.goals
        and _statements(one) == _statements(other)
        and all(alike(one.element(name), other.element(name)) for name in names)
    )


def alike(one: Element, other: Element) -> bool:
    """Returns True where two elements are the same; see :func:`same`."""
    if (one.id, one.type, one.label) != (
        other.id,
        other.type,
        other.label,
    ) or one.properties.keys() != other.properties.keys():
        return False
    return all(_alike(one.properties[name], other.properties[name]) for name in one.properties)


def _statements(index: Index) -> list[tuple[str, str, str]]:
    return [said for said in index.statements() if not is_abstract(said[0])]


def _alike(one: Value, other: Value) -> bool:
    if not isinstance(one, Pose) or not isinstance(other, Pose):
        return type(one) is type(other) and one == other
    difference = one.inverse() @ other
    moved = math.dist(one.position, other.position)
    return moved <= 1e-9 and math.hypot(*difference.orientation[:3]) <= 2e-9
