"""What the documentation shows is run."""

from __future__ import annotations

import ast
import re
import shlex
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from support import warm_python
from support.server_process import ServerProcess

from skiros_py.cli.main import cli

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
SERVED = ("rest.md", "ontologies.md")
"""Pages elsewhere whose examples are for a server that runs."""
PLUGIN = (
    ["-p", "no:dash"] if entry_points(group="pytest11", name="skiros") else ["-p", "skiros_py.testing.pytest_plugin"]
)


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


# Tutorials are run as a whole, in an environment of their own; examples for a server that runs have tests below.
@pytest.mark.parametrize(
    "page",
    [p for p in PAGES if blocks(p, "python") and p.parent.name not in ("tutorials", "rest") and p.name not in SERVED],
    ids=lambda p: p.name,
)
def test_python_examples_run_as_printed(page, tmp_path):
    text = "\n".join(blocks(page, "python"))
    tests = re.search(r"^(def test_|class Test)", text, re.MULTILINE) is not None
    script = tmp_path / "test_example.py"
    script.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", *PLUGIN, str(script)] if tests else [sys.executable, str(script)]

    done = warm_python.run(command, cwd=tmp_path)

    assert done.returncode == 0, done.stdout + done.stderr
    checks = tests or "assert " in text or page.name in ("world.md", "records.md")
    assert checks or "goal reached" in done.stdout


def test_the_recording_of_a_run_is_read_as_documented(tmp_path):
    cli.main(args=["run", "kitting", "--fake", "--data", str(tmp_path)], standalone_mode=False)
    example = {}
    exec("\n".join(blocks(ROOT / "docs" / "how-to" / "records.md", "python")), example)

    way = example["path_of"]("base_1", tmp_path)
    said = example["captions"](next((tmp_path / "runs").iterdir()))

    assert any("drive" in sentence for sentence in said)

    assert len(way) > 1
    assert all(len(place) == 2 for place in way)


def test_the_small_scene_of_the_docs_is_planned_and_runs(tmp_path, monkeypatch, capsys):
    page = ROOT / "docs" / "scenes.md"
    (tmp_path / "small.ttl").write_text(blocks(page, "turtle")[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    commands = [line[2:] for line in blocks(page, "console")[0].splitlines()]

    statuses = [cli.main(args=shlex.split(command)[1:], standalone_mode=False) for command in commands]

    assert statuses == [0, 0, 0]
    assert "goal reached" in capsys.readouterr().out


def test_the_second_robot_of_the_docs_can_be_added_to_the_small_scene(tmp_path, capsys):
    small, second, *_ = blocks(ROOT / "docs" / "scenes.md", "turtle")
    (tmp_path / "two.ttl").write_text(small + second, encoding="utf-8")

    status = cli.main(args=["scene", "show", str(tmp_path / "two.ttl")], standalone_mode=False)

    assert status == 0
    assert "gripper_2" in capsys.readouterr().out


def test_the_world_commands_of_the_docs_work(tmp_path, monkeypatch, capsys):
    from skiros_py.station.worlds import open_data
    from skiros_py.world.branches import learn
    from skiros_py.world.change import Writer

    with open_data(tmp_path / "data", "kitting") as data:
        with data.world.transaction("teach", "shown by hand") as tx:
            learn(tx, "kit_1")
        with data.world.transaction("anna", "by hand", writer=Writer.PERSON) as tx:
            tx.place("starter_1", "sk:in", "pallet_b")
    monkeypatch.chdir(tmp_path)
    lines = [line[2:] for block in blocks(ROOT / "docs" / "world.md", "console") for line in block.splitlines()]

    for line in lines:
        status = cli.main(
            args=shlex.split(line.replace("DIR", "data").replace("NEW", "new"))[1:], standalone_mode=False
        )
        assert not status, line
        assert capsys.readouterr().out or "save" in line or "diff" in line, line


def test_the_commands_of_the_page_about_ontologies_work(tmp_path, monkeypatch, capsys):
    page = ROOT / "docs" / "how-to" / "ontologies.md"
    upper, catalogue = blocks(page, "xml")
    (tmp_path / "public").mkdir()
    (tmp_path / "tools.ttl").write_text(blocks(page, "turtle")[0], encoding="utf-8")
    (tmp_path / "public" / "catalog-v001.xml").write_text(catalogue, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SKIROS_ONTOLOGIES", "")
    missing, *lines = [line for block in blocks(page, "console") for line in block.splitlines()]
    for line in (missing, *lines):
        if line == missing:
            (tmp_path / "public" / "catalog-v001.xml").rename(tmp_path / "catalogue")
        if line.startswith("$ export "):
            for setting in line.split()[2:]:
                monkeypatch.setenv(*setting.split("="))
        elif line.startswith("$ "):
            status = cli.main(args=shlex.split(line)[2:], standalone_mode=False)
            shown = capsys.readouterr().out
            assert bool(status) == (line == missing), shown
        else:
            assert line in shown
        if line == missing:
            (tmp_path / "public" / "upper.owl").write_text(upper, encoding="utf-8")
            (tmp_path / "catalogue").rename(tmp_path / "public" / "catalog-v001.xml")


def test_the_client_example_of_the_page_about_ontologies_works(tmp_path):
    (example,) = blocks(ROOT / "docs" / "how-to" / "ontologies.md", "python")

    with ServerProcess("kitting", "--fake", "--pace", "max", data=tmp_path) as server:
        names = {}
        with server.client() as client:
            exec(re.sub(r"with Client\(.*\) as client:", "if True:", example), {"client": client} | names)
            assert not client.learned.list().items


def test_the_commands_of_the_docs_for_a_served_station_work(tmp_path, monkeypatch, capsys):
    page = ROOT / "docs" / "rest" / "commands.md"
    monkeypatch.chdir(tmp_path)
    lines = [line[2:] for block in blocks(page, "console") for line in block.splitlines()]

    with ServerProcess("kitting", "--fake", "--pace", "max", data=tmp_path / "cell"):
        for line in lines:
            status = cli.main(args=shlex.split(line)[1:], standalone_mode=False)
            assert not status, line
            assert capsys.readouterr().out or "save" in line, line


@pytest.mark.parametrize(
    "page", [p for p in PAGES if p.parent.name == "rest" and blocks(p, "python")], ids=lambda p: p.name
)
def test_everything_imported_by_the_server_examples_exists(page):
    statements = ast.parse("\n".join(blocks(page, "python"))).body

    exec(
        compile(ast.Module([s for s in statements if isinstance(s, ast.Import | ast.ImportFrom)], []), page, "exec"), {}
    )


def test_the_client_example_of_the_docs_orders_a_job(tmp_path):
    example = {}
    for block in blocks(ROOT / "docs" / "rest" / "client.md", "python"):
        exec(block, example)

    with ServerProcess("kitting", "--fake", "--pace", "max", data=tmp_path):
        outcome = example["fill"](tmp_path)

    assert outcome == "succeeded"


def test_the_example_part_of_the_docs_is_a_valid_class(tmp_path):
    from skiros_py.config import ontology_paths
    from skiros_py.geometry import Solid
    from skiros_py.world.ontology import Ontology

    prefixes = "\n".join(
        line
        for line in (ROOT / "ontologies" / "kitting.ttl").read_text(encoding="utf-8").splitlines()
        if "@prefix" in line
    )
    file = tmp_path / "pump.ttl"
    part = next(block for block in blocks(ROOT / "docs" / "scenes.md", "turtle") if "kitting:Pump" in block)
    file.write_text(f"{prefixes}\n{part}", encoding="utf-8")

    ontology = Ontology.load([*ontology_paths(), file])

    assert ontology.is_a("kitting:Pump", "sk:Manipulatable")
    assert Solid.from_json(str(ontology.class_value("kitting:Pump", "sk:solid"))).primitives


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_between_pages_have_existing_targets(page):
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8"))

    missing = [link for link in links if not (page.parent / link).exists()]

    assert missing == []
