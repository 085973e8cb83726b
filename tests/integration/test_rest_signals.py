"""The signals of a cell over HTTP: listed, read in one cycle, and set where they are inputs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import pytest
from click.testing import CliRunner
from support.serving import serving

from skiros_py.catalogue.loading import load_catalogue
from skiros_py.cli.main import cli
from skiros_py.client import Client
from skiros_py.client.request import ProblemError
from skiros_py.ports.signals import Input, Request, Signal, Value


class Half:
    """Half of the speed limit; refuses a limit of zero."""

    name = "half the limit"
    provides = (Signal("half_limit", "m/s", help="Half of the speed limit."),)
    requests = (Request("speed_limit"),)
    every_cycle = False

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        limit = inputs["speed_limit"]
        assert isinstance(limit, float)
        return {"half_limit": limit / 2.0} if limit else {}


class Broken:
    """Raises when it is computed."""

    name = "maker of odd"
    provides = (Signal("odd"),)
    requests = ()
    every_cycle = False

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        raise KeyError("boom")


def providers(_cell: Any) -> list[Any]:
    return [Input(Signal("speed_limit", "m/s", help="Greatest speed that people allow."), 0.5), Half(), Broken()]


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    catalogue = load_catalogue()
    with (
        serving(
            "kitting",
            tmp_path_factory.mktemp("data"),
            catalogue=replace(catalogue, signals={**catalogue.signals, "limits": providers}),
        ) as running,
        Client(running.url) as client,
    ):
        yield client


def test_device_signals_computed_signals_and_inputs_are_listed_alike(client: Client) -> None:
    told = {one.name: one for one in client.signals.list().items}

    assert (told["gripper_1.force"].unit, told["gripper_1.force"].source) == ("N", "gripper_1")
    assert (told["half_limit"].dimension, told["localiser_1.yaw"].dimension) == ("speed", "angle")
    assert (told["half_limit"].help, told["half_limit"].source) == ("Half of the speed limit.", "half the limit")
    assert [name for name, one in told.items() if one.input] == ["speed_limit"]


def test_setting_an_input_changes_the_signals_computed_from_it(client: Client) -> None:
    client.signals.set("speed_limit", 0.3)

    deadline = time.monotonic() + 20.0
    while (read := client.signals.read("speed_limit", "half_limit")).signals["speed_limit"].value != 0.3:
        assert time.monotonic() < deadline
    assert read.signals["half_limit"].value == pytest.approx(0.15)


def test_an_input_is_set_from_the_shell(client: Client) -> None:
    said = CliRunner().invoke(cli, ("signal", "set", "speed_limit", "0.4", "--url", client.url), catch_exceptions=False)

    assert said.output == "speed_limit is 0.4\n"
    deadline = time.monotonic() + 20.0
    while client.signals.read("speed_limit").signals["speed_limit"].value != 0.4:
        assert time.monotonic() < deadline


def test_a_signal_without_a_value_gives_the_reason(client: Client) -> None:
    client.signals.set("speed_limit", 0.0)

    deadline = time.monotonic() + 20.0
    while (half := client.signals.read("half_limit").signals["half_limit"]).value is not None:
        assert time.monotonic() < deadline
    assert half.reason == "half the limit gives none in this cycle"


def test_switching_off_a_signal_provider_raises_an_alarm(client: Client) -> None:
    client.signals.read("odd")

    deadline = time.monotonic() + 20.0
    while not (found := [one for one in client.alarms.list().items if one.source == "signal provider maker of odd"]):
        assert time.monotonic() < deadline
    assert "was switched off" in found[0].text
    assert "it raised KeyError: 'boom'" in found[0].text


def test_setting_a_signal_that_is_not_an_input_or_an_invalid_value_is_refused(client: Client) -> None:
    with pytest.raises(ProblemError, match="only inputs can be set"):
        client.signals.set("half_limit", 1.0)
    with pytest.raises(ProblemError, match="finite number"):
        client.signals.set("speed_limit", (1.0, 2.0))
    with pytest.raises(ProblemError, match="nonsense"):
        client.signals.read("nonsense")
