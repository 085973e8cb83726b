from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from skiros_py import errors
from skiros_py.errors import (
    FileError,
    GoalSyntaxError,
    MissingExtra,
    MissingSystemLibrary,
    NotFound,
    Refused,
    SkirosError,
    UnknownName,
    WorldError,
)

EXAMPLES = [
    errors.DocumentError([errors.DocumentFault("children[1]", "it has no seconds", 2, 7)], "tree:a"),
    errors.DescriptionError("it has no seconds", "children[1]"),
    UnknownName("scene", "kiting", ["kitting", "empty"], where="on the command line"),
    GoalSyntaxError("In(", 4, "expected a name"),
    FileError(Path("a.ttl"), "is not Turtle", line=3),
    FileError(Path("a.ttl"), "is missing"),
    MissingExtra("ontology", "entailment"),
    MissingSystemLibrary("open3d", "libGL.so.1", "libgl1"),
    WorldError("refused"),
    NotFound.of(UnknownName("job", "a", ["b"]), "UnknownJob"),
    Refused("NoPlan", "there is no plan", reasons=["the box is full"]),
]


FAULTS = [
    kind
    for kind in vars(errors).values()
    if isinstance(kind, type) and issubclass(kind, BaseException) and kind.__module__ == errors.__name__
]


def test_every_fault_is_of_the_one_tree() -> None:
    assert errors.Locked in FAULTS
    assert all(issubclass(kind, SkirosError) for kind in FAULTS)


def test_the_tree_drawn_names_every_fault() -> None:
    assert errors.__doc__ is not None
    for kind in FAULTS:
        assert kind.__name__ in errors.__doc__


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda e: type(e).__name__)
def test_faults_survive_the_way_out_of_a_worker_process(error: SkirosError) -> None:
    copy = pickle.loads(pickle.dumps(error))

    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


def test_an_unknown_name_gives_the_nearest_whatever_its_case() -> None:
    error = UnknownName("condition", "HOLDIN", ["Holding", "At"])

    assert error.nearest == "Holding"
    assert str(error) == "unknown condition 'HOLDIN'. Did you mean 'Holding'? Known: At, Holding."


def test_an_unknown_name_that_resembles_nothing_gets_no_guess() -> None:
    assert UnknownName("robot", "zzz", ["robot_1"]).nearest is None
    assert UnknownName("scene", "warehouse", ["kitting_two", "sorting", "greenhouse_cell"]).nearest is None
    assert UnknownName("skill", "drill", ["drive", "place"]).nearest in (None, "drive")
    assert str(UnknownName("robot", "zzz", [])) == "unknown robot 'zzz'. There is none."


def test_of_very_many_names_twenty_are_shown() -> None:
    error = UnknownName("part", "x", [f"part_{n:02}" for n in range(50)])

    assert str(error).endswith("part_19, ….")
    assert len(error.known) == 50


def test_a_goal_error_points_at_its_column() -> None:
    assert str(GoalSyntaxError("In(!", 4, "expected a name")).splitlines() == [
        "goal, column 4: expected a name",
        "  In(!",
        "     ^",
    ]


@pytest.mark.parametrize(("line", "text"), [(3, "a.ttl:3: bad"), (None, "a.ttl: bad")])
def test_a_file_error_begins_with_file_and_line(line: int | None, text: str) -> None:
    assert str(FileError(Path("a.ttl"), "bad", line=line)) == text
