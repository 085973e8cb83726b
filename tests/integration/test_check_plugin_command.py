"""``skiros check-plugin`` on what is installed, and on packages in folders."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from skiros_py.cli.main import cli
from skiros_py.errors import UnknownName, UsageError
from skiros_py.skills.lint.checking import RULES

GOOD = """
from dataclasses import replace
from skiros_py.testing.tiny import DRIVE, pretend
HOP = pretend(replace(DRIVE, name="hop"))
"""
BAD = """
from dataclasses import replace
from skiros_py.behaviours import Do
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import AT_LOCATION, DRIVE

SKIP = Skill(replace(DRIVE, name="skip"), Do.of("fly"))
"""
CONDITION = '[project.entry-points."skiros.conditions"]\nReachable = "skiros_py.testing.tiny:REACHABLE"\n'


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["check-plugin", *arguments], standalone_mode=False, catch_exceptions=False)


def written(folder: Path, name: str, text: str, points: str) -> Path:
    package = folder / name
    (package / "src").mkdir(parents=True)
    (package / "src" / f"{name}.py").write_text(text, encoding="utf-8")
    project = f'[project]\nname = "{name}"\nversion = "0.1"\n{points}'
    (package / "pyproject.toml").write_text(project, encoding="utf-8")
    return package


def skill(name: str, value: str) -> str:
    return f'[project.entry-points."skiros.skills"]\n{name} = "{value}"\n'


@pytest.mark.parametrize("package", ["skiros-py", "skiros-skills", "skiros-primitives", "skiros-robots"])
def test_the_built_in_plug_ins_keep_all_rules_and_their_skills_do_what_they_declare(package: str) -> None:
    result = run(package, "--strict", "--json")

    answer = json.loads(result.stdout)
    assert (result.return_value, answer["findings"]) == (0, [])
    skills = {"drive", "pick", "place"} if package == "skiros-skills" else set()
    assert {ran["skill"] for ran in answer["ran"]} >= skills
    assert all(ran["where"] for ran in answer["ran"])


def test_skills_for_real_robots_are_listed_as_skipped() -> None:
    told = run("skiros-skills").stdout
    answer = json.loads(run("skiros-skills", "--json").stdout)

    assert "not run: skill drive: it needs a real or simulated robot (--simulate SCENE)" in told
    skills = ("drive", "hand_over", "pick", "place", "search")
    assert [one["skill"] for one in answer["not_run"]] == [f"skill {name}" for name in skills]
    assert {ran["driver"] for ran in answer["ran"]} == {"fake"}


def test_a_simulation_in_which_nothing_runs_and_an_unknown_scene_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="contradict each other"):
        run("skiros-skills", "--no-run", "--simulate", "kitting")
    with pytest.raises(UnknownName, match=r"Did you mean .kitting."):
        run("skiros-skills", "--simulate", "kiting")


MANUAL = Path(__file__).parents[2] / "docs" / "rules.md"
LINES = re.findall(r"^\$ skiros check-plugin (.+)$", MANUAL.read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.parametrize(
    "line", [pytest.param(one, marks=pytest.mark.physics) if "--simulate" in one else one for one in LINES]
)
def test_the_commands_of_the_manual_find_nothing_wrong(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(written(tmp_path, f"sk_hop_{LINES.index(line)}", "", CONDITION))

    result = run(*line.split())

    assert (result.return_value, "error" in result.stdout.replace("0 errors", "")) == (0, False)


def test_a_finding_says_file_line_and_rule_and_ends_the_command_with_1(tmp_path: Path) -> None:
    package = written(tmp_path, "sk_skip", BAD, skill("skip", "sk_skip:SKIP"))

    result = run(str(package), "--no-run")

    file = package / "src" / "sk_skip.py"
    assert result.return_value == 1
    assert f"{file}:7: unknown-module: skill skip: there is no primitive or skill 'fly'" in result.stdout
    assert "sk_skip 0.1: 2 parts, " in result.stdout


def test_only_the_selected_rules_are_checked(tmp_path: Path) -> None:
    package = written(tmp_path, "sk_skip_2", BAD, skill("skip", "sk_skip_2:SKIP"))

    result = run(str(package), "--no-run", "--rule", "missing-unit")

    assert (result.return_value, len(result.stdout.splitlines())) == (0, 1)


def test_the_checked_package_is_unloaded_afterwards(tmp_path: Path) -> None:
    before = list(sys.path)

    run(str(written(tmp_path, "sk_gone", GOOD, skill("hop", "sk_gone:HOP"))), "--no-run")

    assert sys.path == before
    with pytest.raises(Exception, match="unknown distribution with plug-ins 'sk_gone'"):
        run("sk_gone")


def test_a_plug_in_that_does_not_load_is_a_finding_at_the_line_that_raised(tmp_path: Path) -> None:
    package = written(tmp_path, "sk_boom", "x = 1\ny = x / 0\n", skill("boom", "sk_boom:BOOM"))

    result = run(str(package))

    assert result.return_value == 1
    line = next(line for line in result.stdout.splitlines() if "does-not-load" in line)
    assert line.startswith(f"{package / 'src' / 'sk_boom.py'}:2: does-not-load: skill boom: ZeroDivisionError")


def test_a_condition_on_a_missing_parameter_is_reported_with_its_rule(tmp_path: Path) -> None:
    text = "from skiros_py.testing.tiny import *\nfrom dataclasses import replace\n"
    text += 'HOP = pretend(replace(DRIVE, name="hop", pre=(AT_LOCATION("Robbot", "Location"),)))\n'
    package = written(tmp_path, "sk_stray", text, skill("hop", "sk_stray:HOP"))

    result = run(str(package), "--json")

    (finding,) = json.loads(result.stdout)["findings"]
    assert (finding["rule"], finding["line"]) == ("missing-parameter", 3)
    assert "Did you mean 'Robot'?" in finding["text"]


@pytest.mark.parametrize(
    ("project", "said"),
    [
        (None, "cannot be read"),
        ("not toml", "is no TOML"),
        ('[project]\nname = "x"\n', "names no plug-ins"),
        ('[project.entry-points."skiros.skills"]\na = "b:c"\n', "names no plug-ins"),
    ],
)
def test_a_folder_that_is_not_a_package_is_refused_with_a_message(
    tmp_path: Path, project: str | None, said: str
) -> None:
    if project is not None:
        (tmp_path / "pyproject.toml").write_text(project, encoding="utf-8")

    with pytest.raises(Exception, match=said):
        run(f"{tmp_path}/")


def test_every_rule_has_a_page_that_can_be_shown() -> None:
    for rule in RULES.values():
        assert run("--explain", rule.name).stdout == rule.page


def test_an_unknown_rule_is_answered_with_the_most_similar_rule() -> None:
    for option in ("--rule", "--explain"):
        with pytest.raises(Exception, match=r"unknown rule .unknown-wort.\. Did you mean .unknown-word.\?"):
            run(option, "unknown-wort")


def test_the_rules_can_be_listed() -> None:
    assert [line.split()[0] for line in run("--rules").stdout.splitlines()] == list(RULES)
    assert [rule["name"] for rule in json.loads(run("--rules", "--json").stdout)["rules"]] == list(RULES)
