"""An operation is declared by its signature; its call follows from that."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import Job, JobOrder
from skiros_py.api.world import ElementPatch
from skiros_py.client.operation import Operation
from skiros_py.client.request import Call, arguments_of
from skiros_py.client.topics import (
    Devices,
    Elements,
    Goals,
    Jobs,
    Modules,
    Ontology,
    Scenes,
    Signals,
    Simulation,
    Topics,
)


class Blocking:
    def send(self, call: Call[Any]) -> Any:
        return call


class Awaiting:
    async def send(self, call: Call[Any]) -> Any:
        return call


def operations() -> list[tuple[str, Operation[..., Any]]]:
    parts = vars(Topics[Any](None)).items()
    return [
        (f"{name}.{operation}", value)
        for name, part in parts
        for operation, value in vars(type(part)).items()
        if isinstance(value, Operation)
    ]


@pytest.mark.parametrize(("name", "operation"), operations())
def test_each_operation_has_types_that_can_be_read(name: str, operation: Operation[..., Any]) -> None:
    assert operation.signature.return_annotation is not operation.signature.empty, name
    assert operation.__doc__


def test_a_blocking_client_method_sends_the_call_of_its_operation() -> None:
    assert Topics(Blocking()).jobs.get("kit-17") == Jobs.get("kit-17")  # type: ignore[comparison-overlap]


def test_a_method_of_an_asynchronous_client_is_awaited() -> None:
    async def ask() -> Job:
        return await Topics(Awaiting()).jobs.get("kit-17")

    assert asyncio.run(ask()) == Jobs.get("kit-17")


def test_parameters_go_into_path_and_query_except_none() -> None:
    call = Elements.list(class_="kitting:Kit", limit=5)

    assert (call.method, call.path) == ("GET", "/elements")
    assert arguments_of(call)["params"] == {"class": "kitting:Kit", "limit": 5}
    assert Signals.read("a", "b").query == {"name": ["a", "b"]}
    assert Jobs.list(states=["Running"]).query["state"] == ["Running"]


def test_plain_values_form_the_body_and_query_parameters_the_query() -> None:
    run = Modules.run("arm_1", "pick", repeat=2)
    reset = Simulation.reset(force=True)

    assert (run.path, run.json) == ("/modules/arm_1/pick/runs", {"repeat": 2, "breakpoints": []})
    assert (reset.query, reset.json) == ({"force": True}, None)


def test_a_body_without_values_is_sent_as_an_empty_object() -> None:
    assert Devices.teach("arm_1").json == {}


def test_a_model_is_sent_with_only_its_given_fields() -> None:
    assert Elements.edit("a", ElementPatch(properties={"sk:mass": None})).json == {"properties": {"sk:mass": None}}


def test_checking_an_order_sends_only_its_goal() -> None:
    assert Goals.check(JobOrder(goal="InKit(a, b)", priority=3)).json == GoalOrder(goal="InKit(a, b)").model_dump(
        mode="json", exclude_unset=True
    )


@pytest.mark.parametrize(
    ("call", "header"),
    [
        (Elements.remove("a", version=7), '"7"'),
        (Elements.remove("a"), "*"),
        (Jobs.stop("a", seen=0), '"0"'),
        (Jobs.stop("a"), None),
        (Goals.put([], seen='"x"'), '"x"'),
        (Scenes.upload("", version=3), '"3"'),
    ],
)
def test_versions_are_sent_as_if_match(call: Call[Any], header: str | None) -> None:
    assert call.headers.get("If-Match") == header


def test_the_language_of_an_answer_is_sent_as_accept_language() -> None:
    call = Ontology.relations(limit=3, language="de, en;q=0.5")

    assert arguments_of(call)["headers"] == {"Accept-Language": "de, en;q=0.5"}
    assert arguments_of(call)["params"] == {"limit": 3}
    assert arguments_of(Ontology.relations())["headers"] == {}


def test_operations_that_are_not_idempotent_are_not_repeated() -> None:
    assert not Modules.run("arm_1", "pick").repeatable
    assert not Modules.command("r1", "step").repeatable
    assert Modules.command("r1", "pause").repeatable
    assert not Jobs.answer("a", "retry").repeatable
    assert Jobs.answer("a", "retry", question=1).repeatable
