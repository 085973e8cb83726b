"""``skiros manager`` and ``skiros device``: what a server runs with is opened and closed from the shell."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from support.serving import Served, serving

from skiros_py.cli.main import cli
from skiros_py.client import Client, ProblemError
from skiros_py.errors import DeviceError, FileError, UsageError

Ask = Callable[..., Any]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture
def said(served: Served) -> Ask:
    def ask(*arguments: str) -> str:
        result = CliRunner().invoke(cli, (*arguments, "--url", served.url), catch_exceptions=False)
        assert result.exit_code == 0, result.output
        return result.stdout

    return ask


@pytest.fixture
def client(served: Served) -> Iterator[Client]:
    with Client(served.url) as client:
        yield client


def test_a_skill_manager_is_closed_and_opened_from_the_shell(said: Ask, client: Client) -> None:
    assert [line.split()[0] for line in said("manager", "list").splitlines()] == ["arm_1", "base_1"]

    assert said("manager", "close", "arm_1") == "arm_1 is closed\n"
    assert [manager["agent"] for manager in json.loads(said("manager", "list", "--json"))["items"]] == ["base_1"]
    assert {skill.name for skill in client.modules.skills().items} == {"drive"}

    assert said("manager", "open", "arm_1") == "arm_1 offers hand_over, pick, place, search\n"
    assert "pick" in {skill.name for skill in client.modules.skills().items}


def test_a_device_is_closed_and_opened_from_the_shell(said: Ask, client: Client) -> None:
    assert any(
        line.split() == ["gripper_1", "gripper", "robot_1", "open"] for line in said("device", "list").splitlines()
    )

    assert said("device", "close", "gripper_1") == "gripper_1 is closed\n"
    assert not client.devices.get("gripper_1").open
    closed = {device["id"] for device in json.loads(said("device", "list", "--json"))["items"] if not device["open"]}
    assert closed == {"gripper_1"}
    with pytest.raises(ProblemError, match="gripper_1 is closed: open it first") as refused:
        client.devices.jog("gripper_1", {"gap": 0.03})
    assert refused.value.status == 409

    assert json.loads(said("device", "open", "gripper_1", "--json"))["open"]
    assert client.devices.get("gripper_1").open


def test_a_device_is_jogged_and_taught_with_from_the_shell(said: Ask, served: Served, client: Client) -> None:
    moved = json.loads(said("device", "jog", "gripper_1", "--param", "gap=0.03", "--json"))
    aside = said("device", "jog", "base_1", "--param", "dx=0.05")
    taught = said("device", "teach", "base_1", "--param", "location=pallet_a")
    tool = ("device", "jog", "arm_1", "--module", "jog_tool", "--param", "translation=0 0 0.01", "--url", served.url)
    refused = CliRunner().invoke(cli, tool)  # the fake arm has no planner

    assert (moved["module"], moved["status"]) == ("gripper_control", "succeeded")
    assert client.devices.state("gripper_1").signals["gap"] == pytest.approx(0.03)
    assert aside.startswith("moved by 0.0")
    assert taught.startswith("learned as")
    assert isinstance(refused.exception, DeviceError)
    assert str(refused.exception) == "jog_tool of arm_1: there is no planner for the arm: jog the joints instead"


def test_a_missing_element_is_named(client: Client) -> None:
    with pytest.raises(ProblemError, match=r"unknown device 'griper_1'.* Did you mean 'gripper_1'") as refused:
        client.devices.close("griper_1")

    assert refused.value.status == 404


def test_signals_are_listed_read_and_refused_from_the_shell(said: Ask, served: Served) -> None:
    listed = {line.split()[0]: line for line in said("signal", "list").splitlines()}
    name, value = said("signal", "get", "gripper_1.gap").split()
    both = json.loads(said("signal", "get", "gripper_1.gap", "localiser_1.x", "--json"))
    refused = CliRunner().invoke(cli, ("signal", "set", "gripper_1.gap", "0.1", "--url", served.url))
    malformed = CliRunner().invoke(cli, ("signal", "set", "gripper_1.gap", "wide", "--url", served.url))

    assert listed["gripper_1.gap"].split()[1:4] == ["m", "length", "gripper_1"]
    assert (name, float(value)) == ("gripper_1.gap", both["signals"]["gripper_1.gap"]["value"])
    assert set(both["signals"]) == {"gripper_1.gap", "localiser_1.x"}
    assert "'gripper_1.gap' comes from gripper_1: only inputs can be set" in str(refused.exception)
    assert malformed.exit_code == 2
    assert "wide is no finite number" in malformed.output


@pytest.mark.parametrize("number", ["NaN", "1e999", "[Infinity]"])
def test_a_signal_is_not_set_to_a_number_that_is_not_finite(served: Served, number: str) -> None:
    result = CliRunner().invoke(cli, ("signal", "set", "gripper_1.gap", number, "--url", served.url))

    assert result.exit_code == 2
    assert "no finite number" in result.stderr


def test_a_data_directory_and_an_address_are_not_given_together(served: Served, tmp_path: Path) -> None:
    for command in (("stop",), ("job", "list"), ("signal", "list")):
        result = CliRunner().invoke(cli, (*command, "--url", served.url, "--data", str(tmp_path)))

        assert isinstance(result.exception, UsageError)
        assert "--data and --url each name a server" in str(result.exception)


def test_a_document_that_is_no_text_is_refused_by_its_file(served: Served, tmp_path: Path) -> None:
    file = tmp_path / "tree.json"
    file.write_bytes(b"\xff\xfe")

    result = CliRunner().invoke(cli, ("document", "import", "tree", "odd", str(file), "--url", served.url))

    assert isinstance(result.exception, FileError)
    assert "tree.json" in str(result.exception)


def test_an_id_that_no_address_can_hold_is_refused(client: Client) -> None:
    with pytest.raises(UsageError, match="can be no id"):
        client.jobs.get("a\udcff")


def test_an_argument_that_is_nested_too_deeply_is_refused(served: Served) -> None:
    result = CliRunner().invoke(cli, ("call", "goals.check", "order=" + "[" * 5000, "--url", served.url))

    assert isinstance(result.exception, UsageError)
