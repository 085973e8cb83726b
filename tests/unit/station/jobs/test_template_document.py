"""A template is checked when it is written: what is wrong is told with its path, before anybody orders."""

import re

import pytest

from skiros_py.skills.plain import Reader
from skiros_py.station.jobs.template_document import TemplateDocument
from skiros_py.testing.tiny import CONDITIONS, tiny_world


@pytest.fixture(scope="module")
def world():
    return tiny_world()


def faults_of(world, **document):
    kind = TemplateDocument()
    return kind.check(document, Reader({}, CONDITIONS)) or kind.review(document, world, {}, CONDITIONS).faults


def test_a_template_that_can_make_goals_is_fine(world):
    faults = faults_of(
        world,
        parameters=[{"name": "slot", "class": "Slot"}],
        goal=[{"not": {"condition": "Free", "arguments": [{"parameter": "slot"}]}}],
        per_material={"condition": "In", "arguments": [{"material": "class"}, {"parameter": "slot"}]},
    )
    assert faults == ()


def test_arguments_of_wrong_classes_are_faults_and_missing_elements_problems(world):
    def review_of(*arguments, class_="Ball"):
        goal = [{"condition": "In", "arguments": list(arguments)}]
        document = {"parameters": [{"name": "what", "class": class_}], "goal": goal}
        kind = TemplateDocument()
        assert kind.check(document, Reader({}, CONDITIONS)) == ()
        return kind.review(document, world, {}, CONDITIONS)

    wanted = {"parameter": "what"}
    assert review_of(wanted, "slot_1").faults == review_of(wanted, "slot_1").problems == ()
    (constant,) = review_of(wanted, "base_1").faults
    assert str(constant).startswith("goal[0]: In, argument 2 (place): base_1 is a ")
    (parameter,) = review_of(wanted, "slot_1", class_="Robot").faults
    assert "parameter what is any Robot, not only a " in parameter.text
    assert "unknown element 'nowhere'" in review_of(wanted, "nowhere").problems[0].text


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        (
            {"goal": [{"not": {"condition": "Fre", "arguments": ["x"]}}]},
            r"goal\[0\]\.not\.condition: unknown condition",
        ),
        ({"goal": [{"condition": "In", "arguments": ["x"]}]}, r"goal\[0\]\.arguments: In takes 2 \(.*\), got 1"),
        ({"goal": [{"condition": "In"}]}, r"goal\[0\].*arguments: is missing"),
        ({"per_material": {"condition": "In", "arguments": 3}}, r"per_material.*arguments"),
        (
            {"parameters": [{"name": "a", "class": "Slt"}], "goal": [{"condition": "Free", "arguments": ["x"]}]},
            r"parameters\[0\]\.class: unknown class 'Slt'. Did you mean 'Slot'",
        ),
    ],
)
def test_a_fault_is_reported_with_its_path(fields, said, world):
    faults = faults_of(world, **fields)

    assert any(re.search(said, str(fault)) for fault in faults)
    assert all(fault.place for fault in faults)
