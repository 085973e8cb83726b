"""A template is checked when it is written: what is wrong is told with its path, before anybody orders."""

import re

import pytest

from skiros_py.skills.plain import Reader
from skiros_py.station.jobs.templates import TemplateDocument
from skiros_py.testing.tiny import CONDITIONS, tiny_world


@pytest.fixture(scope="module")
def world():
    return tiny_world()


def faults_of(world, **document):
    kind = TemplateDocument()
    return kind.check(document, Reader({}, CONDITIONS)) or kind.review(document, world, {}).faults


def test_a_template_that_can_make_goals_is_fine(world):
    faults = faults_of(
        world,
        parameters=[{"name": "slot", "class": "Slot"}],
        goal=[{"not": {"condition": "Free", "arguments": [{"parameter": "slot"}]}}],
        per_material={"condition": "In", "arguments": [{"material": "class"}, {"parameter": "slot"}]},
    )
    assert faults == ()


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
