from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.skills.conditions import Verdict
from skiros_py.station.worlds import open_world
from skiros_py.testing import tiny_world
from skiros_py.world.world import World
from skiros_skills import conditions

RDF_JSON = "<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"


def solid(x: float, y: float, z: float = 0.03, yaw: float = 0.0) -> str:
    return (
        f'; sk:solid \'[{{"kind": "box", "size": [{x:f}, {y:f}, {z:f}], "at": [0, 0, {z / 2:f}],'
        f' "rpy": [0, 0, {yaw:f}]}}]\'^^{RDF_JSON}'
    )


def world(part: str, room: str) -> World:
    return tiny_world(
        f"scene:part a tiny:Ball ; sk:in scene:box_a {part} . scene:room a tiny:Slot ; sk:on scene:floor {room} ."
    )


def fits(part: str, room: str) -> Verdict:
    (verdict,) = conditions.FITS_IN("part", "room").evaluate(world(part, room)).parts
    return verdict


@pytest.mark.parametrize(
    ("part", "holds"),
    [
        ((0.05, 0.09), True),
        ((0.094, 0.05), True),
        ((0.05, 0.096), False),
        ((0.096, 0.096), False),
        ((0.2, 0.01), False),
    ],
)
def test_a_part_fits_with_five_millimetres_to_spare_both_ways(part: tuple[float, float], holds: bool) -> None:
    assert bool(fits(solid(*part), solid(0.1, 0.1))) is holds


def test_a_long_part_may_lie_along_the_longer_side() -> None:
    assert fits(solid(0.05, 0.15), solid(0.2, 0.1))
    assert fits(solid(0.15, 0.05), solid(0.2, 0.1))
    assert not fits(solid(0.15, 0.15), solid(0.2, 0.1))


def test_the_height_of_a_part_does_not_matter() -> None:
    assert fits(solid(0.05, 0.05, 0.5), solid(0.1, 0.1, 0.01))


def test_a_shape_rotated_within_its_part_needs_room_for_its_corners() -> None:
    assert fits(solid(0.08, 0.08), solid(0.1, 0.1))
    assert not fits(solid(0.08, 0.08, yaw=0.785398), solid(0.1, 0.1))


def test_the_verdict_names_both_sizes() -> None:
    assert fits(solid(0.09, 0.05), solid(0.1, 0.2)).text == "part fits into room: 0.050 x 0.090 m into 0.100 x 0.200 m"
    assert fits(solid(0.2, 0.2), solid(0.1, 0.1)).text.startswith("part does not fit into room: 0.200 x 0.200 m into")


@pytest.mark.parametrize(
    ("part", "room", "who"), [("", solid(1, 1), "part"), (solid(1, 1), "", "room"), ("", "", "part")]
)
def test_a_part_without_a_size_does_not_fit_and_is_named(part: str, room: str, who: str) -> None:
    verdict = fits(part, room)

    assert not verdict
    assert verdict.text == f"the size of {who} is not known"


sizes = st.floats(0.01, 0.3)


@settings(max_examples=20, deadline=None)
@given(sizes, sizes, sizes, sizes)
def test_rotating_part_or_compartment_does_not_change_the_verdict(x: float, y: float, a: float, b: float) -> None:
    answers = {bool(fits(solid(*part), solid(*room))) for part in ((x, y), (y, x)) for room in ((a, b), (b, a))}

    assert len(answers) == 1


def test_every_shipped_part_fits_into_every_shipped_compartment() -> None:
    kitting = open_world("kitting")
    parts, compartments = kitting.instances("kitting:Part"), kitting.instances("kitting:Compartment")

    assert parts
    assert compartments
    for part in parts:
        for compartment in compartments:
            assert conditions.FITS_IN(part, compartment).evaluate(kitting), (part, compartment)
