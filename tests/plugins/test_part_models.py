from __future__ import annotations

import math

import pytest

from skiros_primitives import part_models as models
from skiros_py.config import ontology_paths
from skiros_py.errors import DescriptionError
from skiros_py.station.worlds import open_world
from skiros_py.testing import tiny_world
from skiros_py.world.ontology import Ontology
from skiros_py.world.world import World

RDF_JSON = "<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"
UPRIGHT = '{"kind": "cylinder", "size": [0.03, 0.06], "at": [0, 0, 0.03]}'
KNOB = '{"kind": "cylinder", "size": [0.01, 0.02], "at": [0, 0, 0.07], "rpy": [0, 0, 1.0]}'
LYING = '{"kind": "cylinder", "size": [0.03, 0.06], "at": [0, 0, 0.03], "rpy": [1.5707963267948966, 0, 0]}'
ASIDE = '{"kind": "cylinder", "size": [0.01, 0.02], "at": [0.02, 0, 0.07]}'
BLOCK = '{"kind": "box", "size": [0.05, 0.05, 0.05], "at": [0, 0, 0.025]}'


def part(*blocks: str) -> World:
    """A world with one part of this shape."""
    solid = f"sk:solid '[{', '.join(blocks)}]'^^{RDF_JSON}"
    return tiny_world(f"scene:p a tiny:Ball ; sk:in scene:box_a ; {solid} ; sk:graspHeight 0.03 ; sk:graspWidth 0.05 .")


@pytest.fixture(scope="module")
def kitting() -> World:
    return open_world("kitting")


def test_every_part_type_with_a_shape_has_a_model_in_a_fixed_order(kitting: World) -> None:
    found = [model.type for model in models.part_models(kitting)]

    assert found == ["kitting:Alternator", "kitting:Compressor", "kitting:RelayBox", "kitting:Starter"]


def test_a_type_without_a_shape_has_no_model(kitting: World) -> None:
    assert "kitting:Part" not in [model.type for model in models.part_models(kitting)]
    assert models.part_models(tiny_world()) == ()


def test_a_model_has_the_shape_that_the_ontology_gives(kitting: World) -> None:
    relay = next(m for m in models.part_models(kitting) if m.type == "kitting:RelayBox")

    low, high = relay.solid.bounds()
    assert high - low == pytest.approx([0.059, 0.040, 0.054])


def test_the_grasp_of_a_part_model_comes_from_the_ontology(kitting: World) -> None:
    grasp = models.grasp_of(kitting, "starter_1")

    assert grasp.width == 0.049
    assert grasp.poses[0].position == pytest.approx((0.0, 0.0, 0.032))


def test_every_part_of_the_scene_can_be_grasped_within_its_own_height(kitting: World) -> None:
    heights = {m.type: float(m.solid.bounds()[1][2]) for m in models.part_models(kitting)}
    parts = kitting.instances("kitting:Part")

    assert parts
    for element in parts:
        tool = models.grasp_of(kitting, element).poses[0]
        assert 0.0 < tool.position[2] < heights[kitting.element(element).type]


@pytest.mark.parametrize(
    ("blocks", "turns"),
    [
        ((UPRIGHT,), 8),
        ((UPRIGHT, KNOB), 8),
        ((LYING,), 2),
        ((UPRIGHT, ASIDE), 2),
        ((BLOCK,), 2),
        ((UPRIGHT, BLOCK), 2),
    ],
    ids=["upright", "turned about its axis", "lying", "off the axis", "block", "with a block"],
)
def test_a_rotationally_symmetric_part_has_eight_grasp_directions(blocks: tuple[str, ...], turns: int) -> None:
    poses = models.grasp_of(part(*blocks), "p").poses

    yaws = sorted(pose.yaw % (2.0 * math.pi) for pose in poses)
    assert all(pose.position == pytest.approx((0.0, 0.0, 0.03)) for pose in poses)
    assert len(poses) == turns
    assert yaws == pytest.approx([2.0 * math.pi * k / turns for k in range(turns)])


@pytest.mark.parametrize("given", ["", "sk:graspHeight 0.03", "sk:graspWidth 0.05"])
def test_a_part_without_a_grasp_is_reported_as_a_fault_of_the_ontology(given: str) -> None:
    world = tiny_world(f"scene:p a tiny:Ball ; sk:in scene:box_a ; {given} .")

    with pytest.raises(DescriptionError, match="tiny:Ball has no sk:graspHeight and sk:graspWidth"):
        models.grasp_of(world, "p")


def test_the_shipped_ontologies_define_a_grasp_for_each_shape() -> None:
    ontology = Ontology.load(ontology_paths())

    for class_ in ontology.subclasses("sk:Manipulatable"):
        if ontology.class_value(class_, "sk:solid") is not None:
            assert isinstance(ontology.class_value(class_, "sk:graspHeight"), float), class_
            assert isinstance(ontology.class_value(class_, "sk:graspWidth"), float), class_


def test_a_leaning_hand_holds_what_stands_upright_at_the_same_places() -> None:
    straight = models.downward(0.1, 0.2, 0.5, yaw=0.7)

    one, other = models.leaning([straight])

    for tool in (one, other):
        assert tool.position == pytest.approx(straight.position)
        assert tool.matrix()[:3, 1] == pytest.approx(straight.matrix()[:3, 1])  # the fingers close along the same axis
        assert math.acos(-tool.matrix()[2, 2]) == pytest.approx(math.radians(30.0))
    assert one.matrix()[:2, 2] == pytest.approx(-other.matrix()[:2, 2])  # to either side
