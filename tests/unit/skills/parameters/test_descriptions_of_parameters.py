from __future__ import annotations

import enum
from dataclasses import dataclass, replace

import pytest

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.conditions import Nothing, Related
from skiros_py.skills.parameters import Kind, Param, check_params, missing, param, params_of
from skiros_py.testing.tiny import DRIVE, HOLDING, PICK
from skiros_py.world.vocabulary import IN


class Side(enum.Enum):
    LEFT = "left"
    RIGHT = "right"


EMPTY = Nothing(IN, "it")
BAD = [
    (Param("Box", "tiny:Box", "A box.", length=2), "parameter Box of a test: it is one element, so its length"),
    (Param("Box", "tiny:Box", "A box.", unit="m"), "an element has no unit, so not 'm'"),
    (Param("", "number", "How far."), r"parameter \(without a name\) of a test: its key must be a name"),
    (Param("it", "number", "How far."), "its key must be a name, without '=' and blanks, and not 'it'"),
    (Param("a=b", "number", "How far."), "its key must be a name"),
    (Param("Speed", "number", "How fast.", where=EMPTY), "where, prefer, cost and unique are about elements"),
    (Param("Speed", "number", "How fast.", unique=True), "are about elements, and it is number"),
    (Param("Speed", "number", "How fast.", Kind.HARDWARE), "only an element can be HARDWARE, and it is number"),
    (Param("Speed", "number", "How fast.", Kind.PLANNING), "only an element can be PLANNING"),
    (Param("Speeds", "number", "How fast.", length=-1), "its length cannot be -1: 0 stands for any number of values"),
    (Param("Name", "text", "Which.", limits=(0.0, 1.0)), "limits are for numbers, and it is text"),
    (Param("Speeds", "vector", "How fast.", length=3), "say type 'number' with length 3"),
    (Param("Name", "text", "How called.", unit="m"), "text has no unit, so not 'm'"),
    (Param("Speed", "number", "How fast.", Kind.OFFLINE), "it is OFFLINE and needs a default"),
    (Param("Speed", "number", "How fast.", Kind.CONFIG), "it is CONFIG and needs a default"),
    (Param("Speed", "number", "How fast.", default=1.0), "it is ONLINE and cannot have a default: make it OFFLINE"),
    (Param("Speed", "number", "How fast.", Kind.OPTIONAL, 1.0), "it is OPTIONAL and cannot have a default"),
    (Param("Speed", "number", "How fast.", Kind.OFFLINE, "1"), "its default must be a finite number, not '1'"),
    (Param("Speed", "number", "How fast.", Kind.OFFLINE, True), "its default must be a finite number, not True"),
    (Param("Speed", "number", "How fast.", Kind.OFFLINE, float("nan")), "its default must be a finite number, not nan"),
    (Param("Turns", "integer", "How often.", Kind.OFFLINE, 1.5), "its default must be a whole number, not 1.5"),
    (Param("Fast", "boolean", "How.", Kind.OFFLINE, 1), "its default must be true or false, not 1"),
    (Param("Box", "tiny:Box", "A box.", Kind.OFFLINE, 7), "its default must be the id of an element, not 7"),
    (Param("Side", Side, "Which.", Kind.OFFLINE, "left"), "its default must be a Side, not 'left'"),
    (Param("P", "number", "Gains.", Kind.OFFLINE, (1.0,), length=3), "must be a tuple of 3 values, not (1.0,)"),
    (Param("P", "number", "Gains.", Kind.OFFLINE, 1.0, length=0), "must be a tuple of any number of values, not 1.0"),
    (
        Param("Box", "tiny:Box", "A box.", where=Nothing(IN, "Other")),
        "unknown element parameter 'Other' in a pattern of",
    ),
    (Param("Box", "tiny:Box", "A box.", prefer=Nothing(IN, "Box")), "says nothing about 'it'"),
]


@pytest.mark.parametrize(("bad", "says"), BAD, ids=lambda value: value if isinstance(value, str) else "")
def test_a_wrongly_described_parameter_is_refused_with_what_is_wrong(bad: Param, says: str) -> None:
    with pytest.raises((DescriptionError, UnknownName), match=says.replace("(1.0,)", r"\(1.0,\)")):
        check_params((bad,), "of a test")


def test_an_unknown_type_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown type 'nubmer' of parameter Speed of skill 'drive'.*'number'"):
        replace(DRIVE, params=(*DRIVE.params, Param("Speed", "nubmer", "How fast.")))


def test_two_parameters_with_the_same_key_are_refused() -> None:
    with pytest.raises(DescriptionError, match="two parameters of skill 'drive' are called 'Base'"):
        replace(DRIVE, params=(*DRIVE.params, DRIVE.params[0]))


def test_a_condition_about_a_number_is_refused() -> None:
    params = (*PICK.params, Param("Speed", "number", "How fast."))

    with pytest.raises(
        DescriptionError, match=r"parameter Speed in Holding\(Gripper, Speed\) of skill 'pick'.*is a number"
    ):
        replace(PICK, params=params, post=(HOLDING("Gripper", "Speed"),))


GOOD = [
    Param("Speed", "number", "How fast.", Kind.OFFLINE, 1, "m/s"),
    Param("Gains", "number", "How stiff.", Kind.CONFIG, (1.0, 2), length=0),
    Param("Side", Side, "Which.", Kind.OFFLINE, Side.LEFT),
    Param("Sides", Side, "Which.", Kind.OFFLINE, (Side.LEFT, Side.RIGHT), length=2),
    Param("Box", "tiny:Box", "A box.", where=(EMPTY, Related(IN, "it", "Other")), prefer=EMPTY, cost="sk:mass"),
    Param("What", "class", "Which class.", Kind.OPTIONAL),
]


@pytest.mark.parametrize("good", GOOD, ids=lambda value: value.key)
def test_a_rightly_described_parameter_is_accepted(good: Param) -> None:
    check_params((good, Param("Other", "tiny:Slot", "Another.")), "of a test")


@dataclass(frozen=True)
class _Params:
    device: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
    gains: tuple[float, ...] = param("number", "How stiff.", kind=Kind.OFFLINE, default=(1.0, 2.0), length=2)
    side: Side = param(Side, "Which.", kind=Kind.OFFLINE, default=Side.LEFT)


@dataclass(frozen=True)
class _Fixed:
    speed: float = param("number", "How fast.", kind=Kind.ONLINE, default=1.0)


@dataclass(frozen=True)
class _Short:
    speed: float = param("number", "How fast.")
    turns: int = param("integer", "How often.", default=1)


def test_fields_of_primitives_have_lengths_and_types_of_their_own() -> None:
    assert params_of(_Params)[1:] == (
        Param("gains", "number", "How stiff.", Kind.OFFLINE, (1.0, 2.0), length=2),
        Param("side", Side, "Which.", Kind.OFFLINE, Side.LEFT),
    )


def test_fields_of_primitives_are_checked_like_parameters_of_skills() -> None:
    with pytest.raises(DescriptionError, match="parameter speed of _Fixed: it is ONLINE and cannot have a default"):
        params_of(_Fixed)


def test_a_field_with_a_default_is_offline_unless_its_kind_is_said() -> None:
    assert [p.kind for p in params_of(_Short)] == [Kind.ONLINE, Kind.OFFLINE]


def test_parameter_descriptions_are_checked_before_the_preconditions() -> None:
    box = Param("Box", "tiny:Box", "Where it lies.", where=(EMPTY, Related(IN, "Ball", "it")))
    skill = replace(PICK, params=tuple(box if p.key == "Box" else p for p in PICK.params))

    assert [str(need) for need in skill.needs[:2]] == ["BoxAsDescribed(Box)", "BoxAsDescribed(Ball, Box)"]
    assert skill.needs[2:] == skill.pre
    assert [need.pattern for need in skill.needs[:2]] == [Nothing(IN, "Box"), Related(IN, "Ball", "Box")]


def test_requirements_on_a_parameter_name_the_classes_of_their_arguments() -> None:
    box = Param("Box", "tiny:Box", "Where it lies.", where=Related(IN, "Ball", "it"))
    skill = replace(PICK, params=tuple(box if p.key == "Box" else p for p in PICK.params))

    assert [(role.name, role.class_) for role in skill.needs[0].type.roles] == [
        ("Ball", "tiny:Ball"),
        ("Box", "tiny:Box"),
    ]


def test_only_required_parameters_can_be_missing() -> None:
    params = [Param(kind.name, "sk:Arm", "It.", kind) for kind in Kind]

    assert missing(params, {}) == ("ONLINE", "HARDWARE", "PLANNING")
    assert missing(params, {"ONLINE": "arm_1", "HARDWARE": None, "PLANNING": "arm_1"}) == ("HARDWARE",)


def test_an_optional_field_is_left_open_by_default() -> None:
    @dataclass(frozen=True)
    class Params:
        note: str | None = param("text", "For people.", kind=Kind.OPTIONAL)

    assert Params().note is None
    assert params_of(Params)[0].kind is Kind.OPTIONAL
