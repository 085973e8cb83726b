"""The commands of docs/how-to/robot.md, word for word, but for what would change the environment or take minutes."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from support.installed_package import install

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "robot.md"

pytest.importorskip("pybullet_data")
pytest.importorskip("pinocchio")


def test_the_commands_of_the_page_make_a_robot_that_passes_its_tests_and_runs(tmp_path: Path) -> None:
    folder, site = tmp_path, tmp_path / "site"
    path = {"PYTHONPATH": os.pathsep.join([str(site), *filter(None, sys.path)]), "PYTHONDONTWRITEBYTECODE": "1"}

    def run(module: str, *arguments: str) -> str:
        command = [sys.executable, "-m", module, *arguments]
        done = subprocess.run(
            command, cwd=folder, env={**os.environ, **path}, capture_output=True, text=True, timeout=250, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    block = re.search(r"```console\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    for line in block[1].splitlines():
        match shlex.split(line.removeprefix("$ ")):
            case ["skiros", "new", *rest]:
                assert "a pedestal of" in run("skiros_py.cli", "new", *rest)
            case ["cd", name]:
                folder /= name
            case ["pip", "install", "-e", _]:
                install(folder, site)
                path["PYTHONPATH"] = f"{folder / 'src'}{os.pathsep}{path['PYTHONPATH']}"
            case ["pytest"]:  # all of them: minutes of physics
                assert "passed" in run("pytest", "-q", "-p", "no:dash", "-p", "no:cacheprovider", "-k", "TestKinds")
            case ["skiros", "run", scene]:
                assert "goal reached" in run("skiros_py.cli", "run", scene, "--fake")
            case other:
                raise AssertionError(f"nothing runs {other}")
