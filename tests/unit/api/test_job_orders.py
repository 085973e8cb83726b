"""What somebody types becomes an order."""

from dataclasses import asdict

import pytest
from pydantic import ValidationError

from skiros_py.api.goals import Material
from skiros_py.api.jobs import JobOrder, JobPolicy, material_from, order_from
from skiros_py.tasks.policy import Policy


def test_goals_with_their_options_become_an_order():
    order = order_from(("In(a, b)", "In(c, d)"), priority=3, id="x", deadline=None)
    assert order == JobOrder(goal=("In(a, b)", "In(c, d)"), priority=3, id="x")
    assert order_from(("In(a, b)",)).goal == "In(a, b)"


def test_a_template_with_parameters_and_materials_becomes_an_order():
    order = order_from(template="fill kit", parameters={"kit": "kit_1"}, materials=("2*Starter@kit_1_a",))
    assert order.work_master == "fill kit"
    assert order.materials == (Material.model_validate({"class": "Starter", "quantity": 2, "location": "kit_1_a"}),)


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("Starter", {}),
        ("3*Starter", {"quantity": 3}),
        ("Starter=starter_1", {"id": "starter_1"}),
        ("1*Starter = starter_1 @ kit_1", {"id": "starter_1", "location": "kit_1"}),
    ],
)
def test_material_is_parsed_from_its_common_notations(text, fields):
    assert material_from(text) == Material.model_validate({"class": "Starter", **fields})


@pytest.mark.parametrize("text", ["", "x*Starter", "0*Starter", "@kit_1"])
def test_invalid_material_is_refused(text):
    with pytest.raises(ValidationError):
        material_from(text)


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"goal": "In(a, b)", "work_master": "x"},
        {"goal": "In(a, b)", "parameters": {"a": "b"}},
        {"goal": ""},
        {"goal": []},
        {"goal": "In(a, b)", "deadline": "2030-01-01T12:00:00"},
        {"goal": "In(a, b)", "deadline": "0001-01-01T00:00:00+14:00"},
        {"goal": "In(a, b)", "deadline": 1e308},
        {"goal": "In(a, b)", "priority": 1 << 15},
        {"goal": "In(a, b)", "colour": "red"},
    ],
)
def test_an_invalid_order_is_refused(fields):
    with pytest.raises(ValidationError):
        JobOrder.model_validate(fields)


def test_the_defaults_of_ordered_policies_are_those_of_tasks() -> None:
    assert JobPolicy().model_dump() == asdict(Policy())
