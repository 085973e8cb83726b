"""Every command that the documentation shows exists: programs, subcommands, options, groups, extras, files."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from packaging.requirements import Requirement

from skiros_py.cli.main import cli

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")])
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SCRIPTS: dict[str, str] = json.loads((ROOT / "web" / "package.json").read_text(encoding="utf-8"))["scripts"]

_PROGRAMS = ("skiros", "uv", "pip", "python", "python3", "bash", "npm")
_FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(rf"`((?:{'|'.join(_PROGRAMS)}) [^`]+)`")
_LINE = re.compile(rf"(?:    |\$ )?((?:{'|'.join(_PROGRAMS)}) .*)")
_SHELLS = ("", "console", "sh", "bash")


def commands(page: Path) -> Iterator[str]:
    """Yields the commands of a page: in blocks, in indented lines, and in the text."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    blocks = [content for language, content in _FENCED.findall(text) if language in _SHELLS]
    prose = _FENCED.sub("", text)
    indented = [line for line in prose.splitlines() if line.startswith("    ") and "  " not in line.strip(" ")[:60]]
    for line in [*(line for block in blocks for line in block.splitlines()), *indented]:
        if found := _LINE.fullmatch(line):
            yield from found[1].split(" && ")
    yield from (found.replace("\n", " ") for found in _INLINE.findall(prose))


def fault(command: str) -> str:
    """Returns what is wrong with a command; empty for nothing."""
    words = shlex.split(command, comments=True)
    match words:
        case ["skiros", *arguments]:
            return fault_of_skiros(arguments)
        case ["uv", "run", *arguments]:
            return fault_of_uv_run(arguments)
        case ["pip" | "python" | "python3", *arguments] if "install" in arguments:
            return fault_of_install(arguments[arguments.index("install") + 1 :])
        case ["python" | "python3", "-m", module, *_]:
            return "" if module in ("pip", "venv", "pytest") else f"module {module}"
        case ["bash" | "python" | "python3", file, *options]:
            return fault_of_file(file, options)
        case ["npm", "run", script, *_]:
            return "" if script in SCRIPTS else f"npm script {script}"
        case _:
            return ""


def fault_of_skiros(arguments: list[str]) -> str:
    command: click.Command = cli
    context = click.Context(cli)
    try:
        while isinstance(command, click.Group) and arguments and not arguments[0].startswith("-"):
            name, *arguments = arguments
            found = command.get_command(context, name)
            if found is None:
                return f"there is no command {name}"
            command, context = found, click.Context(found, parent=context)
        command.make_parser(context).parse_args(list(arguments))
    except click.UsageError as error:
        return error.format_message()
    return ""


def fault_of_uv_run(arguments: list[str]) -> str:
    groups, extras = PROJECT["dependency-groups"], PROJECT["project"]["optional-dependencies"]
    while arguments and arguments[0].startswith("-"):
        option, *arguments = arguments
        if option in ("--group", "--extra"):
            name, *arguments = arguments
            if name not in (groups if option == "--group" else extras):
                return f"{option} {name}"
        elif option != "--all-groups":
            return option
    match arguments:
        case ["pytest", *paths]:
            return next((path for path in paths if not path.startswith("-") and not (ROOT / path).exists()), "")
        case ["skiros" | "python", *_]:
            return fault(shlex.join(arguments))
        case _:
            return f"uv run {arguments}"


def fault_of_install(packages: list[str]) -> str:
    for package in packages:
        if package.startswith((".", "-")):
            continue
        requirement = Requirement(package)
        known = PROJECT["project"]["optional-dependencies"] if requirement.name == PROJECT["project"]["name"] else ()
        if missing := requirement.extras - set(known):
            return f"extra {', '.join(missing)} of {requirement.name}"
    return ""


def fault_of_file(file: str, options: list[str]) -> str:
    path = next((place / file for place in (ROOT, ROOT / "web") if (place / file).is_file()), None)
    if path is None:
        return f"file {file}"
    text = path.read_text(encoding="utf-8")
    return next((option for option in options if option.startswith("--") and f'"{option}"' not in text), "")


@pytest.mark.parametrize("page", [page for page in PAGES if any(commands(page))], ids=lambda page: page.stem)
def test_documented_commands_and_their_options_exist(page: Path) -> None:
    faults = {command: said for command in commands(page) if (said := fault(command))}

    assert faults == {}


def test_the_check_of_documented_commands_finds_a_wrong_command() -> None:
    wrong = (
        "skiros rum kitting", "skiros run kitting --sead 1", "skiros world hystory", "uv run --group tests pytest",
        "uv run --group test pytest tests/no", "uv run python benchmarks/no.py", "pip install 'skiros-py[no]'",
        "uv run python benchmarks/kitting.py --seads 5", "npm run no", "bash .ci/no",
    )  # fmt: skip

    assert [command for command in wrong if not fault(command)] == []


def test_ci_takes_the_first_two_commands_of_the_readme() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    run, test = re.findall(r"^    (.*uv run .*)$", text, re.MULTILINE)[:2]

    assert "uv run skiros run " in run
    assert test.endswith(" pytest")
