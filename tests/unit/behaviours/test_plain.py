"""Behaviours as plain data: what is written down is read again as the same."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pytest

from skiros_py.behaviours import (
    AssertEffects,
    Behaviour,
    Check,
    Do,
    Every,
    Fallback,
    ForEach,
    Guard,
    Out,
    P,
    Parallel,
    Policy,
    Repeat,
    Retry,
    Sequence,
    Start,
    Timeout,
    Wait,
    WaitUntil,
)
from skiros_py.catalogue import load_catalogue
from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import (
    AllOf,
    Compare,
    Computed,
    Exists,
    Expression,
    IsA,
    Not,
    Nothing,
    all_of,
    any_of,
    exists,
)
from skiros_py.skills.plain import Reader
from skiros_py.testing.tiny import AT_LOCATION, CONDITIONS, FREE, SKILLS

KINDS = load_catalogue().behaviours
READER = Reader(KINDS, CONDITIONS)
DO = Do.of("step", text=P("Text"), times=3, pose=Out("seen"), list=(1, 2.5, None))
THERE = AT_LOCATION("Robot", "Location")
PATTERN = AllOf(
    (Nothing("sk:in", "it"), Not(IsA("it", "tiny:Slot")), Exists("b", "tiny:Ball", Compare("sk:x", "<", "b", 1.5)))
)
NODES: Mapping[str, Behaviour] = {
    "do": DO,
    "start": Start.of("drive", place=P("Place"), altitude=1.5),
    "sequence": Sequence.of(DO, Wait(1)),
    "fallback": Fallback.of(DO, Wait(1.5)),
    "parallel": Parallel.of(DO, DO, policy=Policy.FIRST_SUCCESS),
    "retry": Retry(DO, 3),
    "repeat": Repeat(Repeat(DO, 2)),
    "timeout": Timeout(DO, 0.5),
    "every": Every(0.1, DO),
    "guard": Guard.of(DO, ~THERE, any_of(THERE, FREE("Slot")).named("one of them")),
    "for_each": ForEach("box", "tiny:Box", DO, PATTERN),
    "check": Check.of(all_of(THERE, ~FREE("Slot")), ~exists("r", "sk:Robot", AT_LOCATION("r", "Location"))),
    "wait": Wait(2.0),
    "wait_until": WaitUntil.of("Gripper.force > 2", THERE),
    "assert_effects": AssertEffects(0.5, ("held",)),
}


def through_json(node: Behaviour) -> Any:
    return json.loads(json.dumps(node.to_data(), allow_nan=False))


def test_every_built_in_node_is_registered_by_an_entry_point() -> None:
    assert set(KINDS) == set(NODES)


@pytest.mark.parametrize("kind", sorted(NODES))
def test_a_node_of_each_kind_survives_a_round_trip_through_data(kind: str) -> None:
    again = READER.behaviour(through_json(NODES[kind]))

    assert again == NODES[kind]


def test_the_bodies_of_all_installed_skills_survive_a_round_trip_through_data() -> None:
    catalogue = load_catalogue()
    reader = Reader(catalogue.behaviours, {**catalogue.conditions, **CONDITIONS})
    for skill in (*catalogue.skills.values(), *SKILLS):
        for part in skill.nodes:
            assert reader.behaviour(through_json(part)) == part


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"type": "sequence", "children": [{"type": "wait"}]}, r"children\[0\]: it has no seconds"),
        ({"type": "sequence", "children": [{"type": "wiat", "seconds": 1}]}, r"children\[0\].*wiat.*wait"),
        ({"type": "retry", "child": {"type": "wait", "seconds": -1}, "times": 2}, "child: wait: a number of seconds"),
        ({"type": "wait", "second": 1}, ".*second.*seconds"),
        ({"type": "check", "conditions": [{"condition": "Ta", "arguments": []}]}, r"conditions\[0\]: .*Ta"),
        ({"type": "parallel", "children": [], "policy": "none"}, "a policy is one of first failure"),
        ({"type": "do"}, "^it has no module"),
        (["no node"], "^a node with a type"),
        ({"type": "sequence", "children": [3]}, "it is made of nodes"),
    ],
)
def test_a_fault_in_the_data_is_reported_with_its_path(data: Any, message: str) -> None:
    with pytest.raises(DescriptionError, match=message):
        READER.behaviour(data)


def test_a_node_with_a_function_cannot_be_written_as_data() -> None:
    pattern = Computed("tiny:fits", "it", "Slot", lambda *_: None)  # type: ignore[arg-type,return-value]

    with pytest.raises(DescriptionError, match="cannot be written down"):
        ForEach("box", "tiny:Box", DO, pattern).to_data()


def test_an_expression_survives_a_round_trip_through_data() -> None:
    node = ForEach("box", "tiny:Box", DO, Expression("Gripper.gap < 0.02"))

    assert READER.behaviour(through_json(node)).to_data() == node.to_data()
