"""The tutorial works as printed: in an environment of its own, from wheels, with nothing of the checkout."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "tutorials" / "first-skill.md"
_PART = re.compile(r"^<!-- file: (.+?) -->\n```\w+\n(.*?)^```|^```console\n(.*?)^```", re.MULTILINE | re.DOTALL)


def uv(*arguments: str | Path) -> None:
    program = shutil.which("uv")
    assert program, "uv is how this project is installed: python3 -m pip install uv"
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheels")
    for project in (ROOT, ROOT / "primitives", ROOT / "robots", ROOT / "skills"):
        uv("build", "--quiet", "--wheel", "--out-dir", folder, project)
    return folder


def steps() -> Iterator[tuple[str, str]]:
    """Yields the page's files, as (name, content), and its commands, as ("$", command), in their order."""
    for part in _PART.finditer(PAGE.read_text(encoding="utf-8")):
        if part[1]:
            yield part[1], part[2]
        else:
            yield from (("$", line.removeprefix("$ ")) for line in part[3].splitlines())


def test_the_skill_of_the_tutorial_takes_no_more_than_24_lines() -> None:
    (text,) = (text for what, text in steps() if what == "src/my_scanning/skills/scan.py")

    assert sum(bool(line.strip()) for line in text.splitlines()) <= 24


@pytest.mark.timeout(900)
def test_the_tutorial_leads_from_an_empty_folder_to_a_new_skill_that_is_executed(wheels: Path, tmp_path: Path) -> None:
    home, here = tmp_path, ROOT
    environment = home / "scanning"
    own = {k: v for k, v in os.environ.items() if not k.startswith(("SKIROS", "PYTHON", "VIRTUAL_ENV", "UV_"))}
    own |= {"HOME": str(home), "PATH": f"{environment / 'bin'}:{os.environ['PATH']}", "VIRTUAL_ENV": str(environment)}
    said = {}

    for what, text in steps():
        if what != "$":
            (here / what).write_text(text, encoding="utf-8")
        elif text.startswith("cd "):
            here /= text.removeprefix("cd ").replace("~", str(home))
        elif text.startswith("python3 -m venv"):
            uv("venv", "--quiet", "--python", sys.executable, environment)
        elif text == "pip install build" or "-m build" in text:
            pass  # the fixture has built them; .ci/run builds and installs them with pip
        elif text.startswith("pip install"):  # quicker than pip itself
            words = text.removeprefix("pip install").removeprefix(" --find-links dist").split()
            packages = [word.strip("'") for word in words]
            where = [str(here) + p.removeprefix(".") if p.startswith(".") else p for p in packages]
            uv("pip", "install", "--quiet", "--python", environment, "--find-links", wheels, *where)
        elif not text.startswith(". "):
            command = ["bash", "-c", text]
            done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=here, env=own)
            assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"
            said[text] = done.stdout

    assert "site-packages" in said["skiros plugins scan"]
    assert "scan(arm=arm_1" in said["skiros plan scan_cell"]
    assert "goal reached" in said["skiros run scan_cell --fake"]
    assert "goal reached" in said["skiros run scan_cell"]
    assert re.search(
        r"pre +no +Holding\(gripper, part\)", said["skiros module show scan --scene scan_cell --param part=starter_1"]
    )
