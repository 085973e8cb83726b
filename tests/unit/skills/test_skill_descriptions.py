from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import pytest

from skiros_py.behaviours import AssertEffects, Do, Fallback, P, Retry, Sequence, lines
from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.parameters import Kind, Param, param, params_of
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, FREE, PICK


@dataclass(frozen=True)
class _Good:
    arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
    speed: float = param("number", "How fast.", kind=Kind.OFFLINE, default=0.5, unit="m/s")


@dataclass(frozen=True)
class _Bare:
    speed: float = 0.5


def test_declared_fields_become_parameters() -> None:
    assert params_of(_Good) == (
        Param("arm", "sk:Arm", "The arm.", Kind.HARDWARE),
        Param("speed", "number", "How fast.", Kind.OFFLINE, 0.5, "m/s"),
    )


def test_parameters_whose_type_is_a_class_are_elements() -> None:
    assert [p.is_element for p in params_of(_Good)] == [True, False]


def test_a_field_that_was_not_declared_is_refused_by_its_name() -> None:
    with pytest.raises(DescriptionError, match=r"_Bare\.speed: declare it with param"):
        params_of(_Bare)


def test_a_condition_over_an_unknown_parameter_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown parameter 'Locatoin' in At.*of skill 'drive'.*mean 'Location'"):
        replace(DRIVE, pre=(AT_LOCATION("Robot", "Locatoin"),))


@pytest.mark.parametrize("field", ["pre", "hold", "post"])
def test_pre_hold_and_postconditions_are_all_checked(field: str) -> None:
    with pytest.raises(UnknownName):
        replace(DRIVE, **{field: (FREE("Slot"),)})


@pytest.mark.parametrize("role", ["agent", "target"])
def test_agent_and_target_must_be_parameters(role: str) -> None:
    with pytest.raises(UnknownName, match="as agent or target of skill 'drive'"):
        replace(DRIVE, **{role: "Nobody"})


def test_a_skill_without_postcondition_is_refused() -> None:
    with pytest.raises(DescriptionError, match="no goal could ever need it"):
        replace(DRIVE, post=())


def test_the_agents_class_is_that_of_its_parameter() -> None:
    assert (DRIVE.agent_class, PICK.agent_class) == ("sk:Base", "sk:Arm")


def test_an_unknown_parameter_is_answered_with_those_there_are() -> None:
    with pytest.raises(UnknownName) as caught:
        DRIVE.param("location")

    assert caught.value.nearest == "Location"


def test_a_body_prints_as_an_indented_tree() -> None:
    body = Sequence.of(
        Do.of("look", camera=P("Camera"), height=0.4),
        Retry(Fallback.of(Do.of("grasp"), AssertEffects(2.0)), 3),
    )

    assert lines(body) == [
        "sequence",
        "  look(camera=Camera, height=0.4)",
        "  retry, at most 3 times",
        "    fallback",
        "      grasp()",
        "      pretend for 2 s",
    ]


@pytest.mark.parametrize("times", [0, -1])
def test_a_retry_with_zero_attempts_is_refused(times: int) -> None:
    with pytest.raises(DescriptionError, match=f"retry: at least once, and a whole number of times, not {times}"):
        Retry(Do.of("grasp"), times)


@pytest.mark.parametrize("field", ["hold", "post"])
def test_conditions_that_contradict_each_other_are_refused(field: str) -> None:
    there = AT_LOCATION("Robot", "Location")

    with pytest.raises(DescriptionError, match=rf"^{field} of skill 'drive': At\(.*\) and not At\("):
        replace(DRIVE, **{field: (~there, there)})


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"name": 5}, r"skill name 5: it must be a text"),
        ({"name": ""}, r"skill name '': it must be a text, not empty"),
        ({"post": AT_LOCATION("Robot", "Location")}, r"post of skill 'drive': it must be a tuple, not a Condition"),
        ({"params": list(DRIVE.params)}, r"params of skill 'drive': it must be a tuple, not a list"),
    ],
)
def test_a_declaration_of_a_wrong_type_is_refused_with_a_message(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(DescriptionError, match=says):
        replace(DRIVE, **wrong)
