"""Parts that are only counted: real bodies, of which one gets an individual when a robot sets about taking it."""

from __future__ import annotations

import pytest

from skiros_py.errors import DescriptionError
from skiros_py.station.session import Options, Session

pytestmark = pytest.mark.physics


def test_a_part_from_stock_is_truly_in_its_compartment_at_the_end(open_session):
    session = open_session("kitting_stock", seed=4)

    report = session.run(["ObjectAtLocation(Alternator, kit_1_b)"])

    assert report.reached
    assert [(c.believed, c.true) for c in report.conditions] == [(True, True)]
    assert session.world.instances("kitting:Alternator") == ("alternator_1",)
    assert session.world.value("alternators_a", "sk:stockCount") == 2
    assert session.world.value("relay_boxes_a", "sk:stockCount") == 1


def test_a_stock_is_simulated_as_that_many_bodies_in_its_container(open_session):
    from skiros_py.simulation.truth import Truth

    session = open_session("kitting_stock", seed=4)

    placements = Truth(session.simulation).placements()

    assert {body for body, place in placements.items() if place == "pallet_a"} == {
        *(f"alternators_a#{n}" for n in (1, 2, 3)),
        "relay_boxes_a#1",
    }


def test_goals_by_class_count_stock_bodies_and_individuals_made_from_stock_have_no_truth(open_session):
    from skiros_py.station.judgement import judge
    from skiros_py.world.stock import take

    session = open_session("kitting_stock", seed=4)
    with session.world.transaction("test", "one is known now") as tx:
        take(tx, "alternators_a#1")
    goal = session.parse(
        [
            "ObjectAtLocation(Alternator, pallet_a)",
            "InKit(Alternator, kit_1)",
            "ObjectAtLocation(alternator_1, pallet_a)",
            "ObjectAtLocation(starter_1, pallet_b)",
        ]
    )

    assert judge(session.simulation, session.spec, session.world, goal) == (True, False, None, True)


def test_one_look_detects_that_a_stock_is_empty(open_session):
    session = open_session("kitting_stock", seed=4)
    for number in (1, 2, 3):
        session.simulation.remove_body(f"alternators_a#{number}")

    report = session.run(["ObjectAtLocation(Alternator, kit_1_b)"])

    assert not report.reached
    assert [step.arguments["Object"] for step in report.steps if step.skill == "pick"] == ["alternator_1"]
    assert session.world.value("alternators_a", "sk:stockCount") == 0
    assert session.world.value("alternator_1", "sk:missing") is True


def test_a_stock_larger_than_its_container_is_refused_and_names_the_container(tmp_path):
    from skiros_py.config import find_scene

    file = tmp_path / "much.ttl"
    text = find_scene("kitting_stock").read_text(encoding="utf-8")
    file.write_text(text.replace("sk:stockCount 3", "sk:stockCount 500"), encoding="utf-8")

    with (
        pytest.raises(DescriptionError, match=r"no room on 'pallet_a' for .* and 493 more"),
        Session(str(file), Options()),
    ):
        pass
