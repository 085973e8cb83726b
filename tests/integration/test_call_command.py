"""``skiros call``: each operation of the API from the shell."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from support.serving import Served, serving

from skiros_py.cli.main import cli
from skiros_py.errors import FileError, UnknownName, UsageError


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


def call(served: Served, *arguments: str) -> Result:
    return CliRunner().invoke(cli, ("call", *arguments, "--url", served.url), catch_exceptions=False)


def test_an_operation_prints_its_result_as_json(served: Served) -> None:
    found = json.loads(call(served, "elements.list", "class_=kitting:Starter", "limit=2").stdout)

    assert [one["class"] for one in found["items"]] == ["kitting:Starter"]


def test_arguments_are_parsed_as_the_types_that_the_operation_declares(served: Served) -> None:
    added = call(
        served,
        "elements.add",
        'new={"class": "kitting:Starter", "id": "spare", "placement": {"relation": "sk:in", "place": "pallet_a"}}',
    )
    assert json.loads(added.stdout)["id"] == "spare"

    signals = json.loads(call(served, "signals.read", 'names=["gripper_1.gap"]').stdout)
    assert list(signals["signals"]) == ["gripper_1.gap"]


def test_text_results_are_printed_verbatim_and_arguments_are_read_from_files(served: Served, tmp_path: Path) -> None:
    turtle = call(served, "scenes.turtle").stdout
    assert "scene:this" in turtle

    file = tmp_path / "scene.ttl"
    file.write_text(turtle)
    assert json.loads(call(served, "scenes.upload", f"text=@{file}").stdout)["name"] == ""


def test_call_without_an_operation_lists_all_operations() -> None:
    listed = CliRunner().invoke(cli, ("call",), catch_exceptions=False).stdout.splitlines()

    assert "scenes.load name=… [version=…]" in listed
    assert all(line.startswith("    ") and line.endswith(".") for line in listed[1::2])


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        (("scenes.lode",), UnknownName, "Did you mean 'scenes.load'"),
        (("scenes.load", "title=kitting"), UnknownName, "unknown argument 'title'"),
        (("scenes.load",), UsageError, "needed: name=… [version=…]"),
        (("scenes.load", "name=kitting", "version=new"), UsageError, "version: must be a whole number"),
        (("signals.read", "names=gripper_1.gap"), UsageError, "names: must be a list; what is not text is"),
        (("scenes.upload", "text=@missing.ttl"), FileError, "there is no such file"),
    ],
)
def test_a_wrong_operation_or_argument_is_named(arguments: tuple[str, ...], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match="(?s)" + words.replace("[", r"\[")):
        CliRunner().invoke(cli, ("call", *arguments), catch_exceptions=False)
