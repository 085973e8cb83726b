"""Elements are found by what is known of them, and what cannot be found says why."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.element import Placement
from skiros_py.world.lookup import resolve, the
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import load_reasoners
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

PARTS = ("alternator_1", "compressor_1", "relay_box_1", "relay_box_2", "starter_1")


@pytest.fixture
def computing(ontology: Ontology, root: Path) -> World:
    return load_scene(ontology, root / "scenes" / "kitting.ttl", reasoners=load_reasoners()[0])


def test_subclasses_count_and_the_ids_are_sorted(world: World) -> None:
    assert resolve(world, "kitting:Part") == PARTS
    assert resolve(world, "kitting:RelayBox") == ("relay_box_1", "relay_box_2")


def test_resolve_without_a_class_finds_every_element_of_the_scene(world: World) -> None:
    assert resolve(world) == world.instances("sk:Element")


def test_a_label_must_match_exactly(world: World) -> None:
    assert resolve(world, label="relay box") == ("relay_box_1", "relay_box_2")
    assert resolve(world, label="relay") == ()
    assert resolve(world, label="Relay box") == ()
    assert resolve(world, label="") == ()


def test_a_class_value_matches_until_the_element_has_its_own_value(world: World) -> None:
    assert resolve(world, "kitting:Part", properties={"sk:mass": 0.25}) == ("relay_box_1", "relay_box_2")

    with world.transaction("scale", "weighed") as tx:
        tx.set("relay_box_2", "sk:mass", 0.3)

    assert resolve(world, "kitting:Part", properties={"sk:mass": 0.25}) == ("relay_box_1",)
    assert resolve(world, "kitting:Part", properties={"sk:mass": 0.3}) == ("relay_box_2",)


def test_a_property_can_be_filtered_by_a_function_or_as_not_set(world: World) -> None:
    with world.transaction("look", "not there") as tx:
        tx.set("starter_1", "sk:missedLooks", 2)

    assert resolve(world, properties={"sk:missedLooks": lambda looks: int(looks) > 1}) == ("starter_1",)
    assert resolve(world, "kitting:Part", properties={"sk:missedLooks": None}) == PARTS[:-1]


def test_a_property_function_is_called_only_for_elements_with_a_value(world: World) -> None:
    asked: list[object] = []

    assert resolve(world, properties={"sk:maxGap": lambda gap: asked.append(gap) is None}) == ("gripper_1",)
    assert asked == [world.value("gripper_1", "sk:maxGap")]


def test_all_given_conditions_must_hold_together(world: World) -> None:
    light = {"sk:mass": lambda kg: float(kg) < 0.5}

    assert resolve(world, "kitting:Part", properties=light, relations={"sk:in": "pallet_a"}) == ("relay_box_1",)
    assert resolve(world, relations={"sk:in": "pallet_a", "sk:on": "floor"}) == ()


def test_sub_relations_match_a_super_relation(world: World) -> None:
    assert resolve(world, "kitting:Part", relations={"sk:placement": "pallet_b"}) == ("compressor_1", "relay_box_2")


def test_a_relation_is_read_backwards(world: World) -> None:
    assert resolve(world, relations={"^sk:hasA": "kit_1"}) == tuple(f"kit_1_{letter}" for letter in "abcd")
    assert resolve(world, relations={"^sk:in": "starter_1"}) == ("pallet_a",)


def test_a_computed_relation_is_resolved_in_both_directions(computing: World) -> None:
    with computing.transaction("test", "a bigger part") as tx:
        tx.set("starter_1", "sk:graspWidth", 1.0)

    assert resolve(computing, "kitting:Part", relations={"sk:graspableBy": "gripper_1"}) == PARTS[:-1]
    assert resolve(computing, relations={"^sk:graspableBy": "relay_box_1"}) == ("gripper_1",)
    assert resolve(computing, relations={"^sk:graspableBy": "starter_1"}) == ()


def test_computed_and_stated_relations_can_be_combined(computing: World) -> None:
    wanted = {"sk:graspableBy": "gripper_1", "sk:in": "pallet_a"}

    assert resolve(computing, "kitting:Part", relations=wanted) == ("alternator_1", "relay_box_1", "starter_1")


def test_abstract_elements_are_found_only_on_request(world: World) -> None:
    with world.transaction("teacher", "shown") as tx:
        tx.add("kitting:Kit", "my kit", learned=True)

    assert resolve(world, "kitting:Kit") == ("kit_1",)
    assert resolve(world, "kitting:Kit", abstract=True) == ("kitting:standard_kit", "learned:kit_1")
    of_kit = resolve(world, relations={"^sk:hasA": "kitting:standard_kit"}, abstract=True)
    assert of_kit == world.objects("kitting:standard_kit", "sk:hasA")
    assert resolve(world, relations={"^sk:hasA": "kitting:standard_kit"}) == ()


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"class_": "kitting:Prt"}, "unknown class 'kitting:Prt'. Did you mean 'kitting:Part'"),
        ({"properties": {"sk:mas": 1.0}}, "unknown property 'sk:mas'. Did you mean 'sk:mass'"),
        ({"relations": {"sk:inn": "pallet_a"}}, "unknown relation 'sk:inn'. Did you mean 'sk:in'"),
        ({"relations": {"^sk:inn": "pallet_a"}}, "unknown relation 'sk:inn'. Did you mean 'sk:in'"),
        ({"relations": {"sk:in": "palet_a"}}, "unknown element 'palet_a'. Did you mean 'pallet_a'"),
        ({"relations": {"sk:near": "pallet_a"}}, "unknown computed relation 'sk:near' (no reasoner computes it)"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest_known_name(
    world: World, asked: dict[str, object], says: str
) -> None:
    with pytest.raises(UnknownName) as caught:
        resolve(world, **asked)  # type: ignore[arg-type]

    assert says in str(caught.value)


def test_filtering_by_an_invalid_value_is_an_error_instead_of_an_empty_result(world: World) -> None:
    with pytest.raises(UsageError, match="sk:mass is always a finite number, never 'heavy'"):
        resolve(world, properties={"sk:mass": "heavy"})


def test_the_only_matching_element_is_returned(world: World) -> None:
    assert the(world, "kitting:RelayBox", relations={"sk:in": "pallet_b"}) == "relay_box_2"


def test_several_matching_elements_are_listed_in_the_error(world: World) -> None:
    with pytest.raises(UsageError) as caught:
        the(world, "kitting:Part", label="relay box")

    assert str(caught.value) == (
        "2 elements are a kitting:Part called 'relay box': say which. There are: relay_box_1, relay_box_2."
    )


def test_without_a_match_the_error_lists_the_conditions_and_the_elements_of_the_class(world: World) -> None:
    asked = {"sk:mass": 0.1, "sk:pose": None, "sk:graspWidth": lambda _: True}

    with pytest.raises(UsageError) as caught:
        the(world, "kitting:Starter", properties=asked, relations={"sk:in": "pallet_b"})

    assert str(caught.value) == (
        "there is no kitting:Starter, sk:mass 0.1, sk:pose not set, sk:graspWidth as asked, sk:in 'pallet_b'."
        " Of that class: starter_1."
    )


def test_a_long_list_of_candidates_is_cut_off(world: World) -> None:
    with world.transaction("delivery", "many") as tx:
        for _ in range(30):
            tx.add("kitting:Starter", placement=Placement("sk:in", "pallet_a"))

    with pytest.raises(UsageError) as caught:
        the(world, "kitting:Starter")

    assert str(caught.value).startswith("31 elements are a kitting:Starter: say which.")
    assert str(caught.value).count("starter_") == 20
    assert str(caught.value).endswith(", ….")
