"""Every block of the documentation that shows shell or HTTP is run, and Python for a server, or is listed here."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from support.programs import needs
from support.server_process import ServerProcess

from skiros_py.client import Client

pytestmark = needs(shutil.which("curl"), "curl is not installed")

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")])
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```|(?<=\n\n)((?:    [^\n]*\n|\n(?=    ))+)", re.MULTILINE | re.DOTALL)
_SHELL = re.compile(r"(?:\$ )?(?:skiros|curl|uv|pip|python3?|bash|npm|cd|tools/\S+|for) ")
_REQUEST = re.compile(
    r"^(GET|PUT|POST|PATCH|DELETE) (/[^{\n]*?)\s*(\{.*?)?(?=\n\n|\n[A-Z]+ /|\Z)", re.MULTILINE | re.DOTALL
)
_HTTP = re.compile(r"(?:GET|PUT|POST|PATCH|DELETE) /\S")
_ADDRESS = re.compile(r"http://127\.0\.0\.1:8000|(?<!/)localhost:8000")

ELSEWHERE = {
    "install.md": ".ci/run runs it word for word",
    "first-skill.md": "test_tutorial.py",
    "robot.md": "test_robot_from_urdf.py",
    "start-a-package.md": "it installs into the environment; test_scaffold.py runs such packages",
    "benchmarks.md": "each takes minutes",
    "CONTRIBUTING.md": "it runs all tests",
    "client.md": "test_documentation.py",
    "commands.md": "test_documentation.py",
    "proxy.md": "test_rest_proxy.py",
    "world.md of docs": "test_documentation.py",
    "ontologies.md": "test_documentation.py",
    "scenes.md of docs": "test_documentation.py",
}
"""Pages that are run somewhere else, or cannot be run in a test."""

NOT_RUN = {
    "uv run": "the environment of the tests is that of uv",
    "uv sync": "the same",
    "npm": "the pages are built and checked by .ci/run",
    "cd web": "the same",
    "python openapi.py": "the same",
    "python3 -m pip install uv": ".ci/run runs README's first commands word for word",
    "skiros key revoke 1f0c55a2": "the id differs; test_key_command.py",
    "skiros check-plugin . --rule": "it needs the folder of a package; test_check_plugin_command.py",
    "curl -X PUT localhost:8000/api/v1/scene -H 'If-Match: \"17\"'": "the version differs; test_rest_scenes.py",
    "skiros new robot rail_arm.urdf": "the file is the reader's own; test_robot_from_urdf.py",
    "skiros new ontology line": "it needs the folder of a package; test_scaffold.py",
    "skiros new condition Presented": "the same",
    "skiros rehearse trapped.ttl": "physics, which fails there; tests/scenario/test_rehearsing.py reads the page",
    "skiros check-plugin skiros-skills --simulate": "minutes of physics; tests/scenario runs them",
    "curl -X POST $URL/api/v1/webhooks": "its host does not exist; tests of webhooks have one",
    "POST /skiros ": "what the server sends",
    "GET /previews/1": "the number differs; test_rest_goals.py",
    "POST /jobs/line-1-kit-4711/answer": "it needs a job that waits for a person; test_rest_jobs.py",
}
"""Beginnings of commands and requests that are shown only."""

FIRST = ("world.md", "view.md", "access.md")
"""Pages of the server that show an unchanged world, and come before the others."""


def name(page: Path) -> str:
    """Returns the name of a page; with its folder where two pages have one name."""
    twice = sum(other.name == page.name for other in PAGES) > 1
    return f"{page.name} of {page.parent.name}" if twice and page.parent.name == "docs" else page.name


def blocks(page: Path) -> Iterator[tuple[str, str]]:
    """Yields the blocks of a page as language ("" for none) and text."""
    for found in _BLOCK.finditer(page.read_text(encoding="utf-8")):
        yield (
            (found[1] or "", found[2])
            if found[3] is None
            else ("", re.sub("^    ", "", found[3], flags=re.MULTILINE).strip("\n"))
        )


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yields the commands of a block, each with the lines of output that it shows."""
    prompts, found = "$ " in text, list[tuple[str, list[str]]]()
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("$ ") or (not prompts and line):
            found.append((line.removeprefix("$ "), []))
        elif found:
            found[-1][1].append(line)
    yield from found


def kind(language: str, text: str) -> str:
    """Returns what a block shows: "shell", "http", "python" or "" for data and output."""
    if language == "python":
        return "python"
    return "http" if _HTTP.match(text) else "shell" if _SHELL.match(text) else ""


def is_not_run(text: str) -> bool:
    return text.startswith(tuple(NOT_RUN))


class Reader:
    """Does what a page says, in a folder of its own.

    Attributes:
        faults: What did not go as shown.
    """

    def __init__(self, folder: Path, server: ServerProcess | None = None) -> None:
        self.folder, self.server, self.faults = folder, server, list[str]()
        token = "" if server is None else json.loads((server.data / "server.json").read_text()).get("token", "")
        own = {"URL": "" if server is None else server.url, "KEY": token, "SKIROS_KEY": token}
        self.environment = os.environ | own | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    def read(self, language: str, text: str) -> None:
        """Runs one block."""
        match kind(language, text):
            case "http":
                for method, path, body in _REQUEST.findall(text):
                    self.request(method, path, body, text)
            case "shell":
                for command, shown in commands(text):
                    if not is_not_run(command):
                        self.run(command, shown)
            case "python" if self.server is not None and "Client(" in text and "follow" not in text:
                exec(_ADDRESS.sub(self.server.url, text), {})

    def request(self, method: str, path: str, body: str, block: str) -> None:
        if is_not_run(f"{method} {path} ") or is_not_run(f"{method} {path}"):
            return
        assert self.server is not None
        headers = {"Authorization": f"Bearer {self.environment['KEY']}"}
        body = re.sub(r"\s{3,}\d.*", "", body)
        content = json.loads(body) if body else None
        answer = httpx2.request(method, f"{self.server.url}/api/v1{path}", json=content, headers=headers, timeout=30)
        wanted = re.search(r"^(\d{3}) ", block, re.MULTILINE)
        if answer.status_code != int(wanted[1]) if wanted else answer.is_error:
            self.faults.append(f"{method} {path}: {answer.status_code} {answer.text}")
        for header, value in re.findall(r"^(Location|ETag|Retry-After): (.*)$", block, re.MULTILINE):
            if answer.headers.get(header) != value:
                self.faults.append(f"{method} {path}: {header} is {answer.headers.get(header)}, not {value}")

    def run(self, command: str, shown: list[str]) -> None:
        if command.startswith("skiros serve "):
            self.serve(shlex.split(command)[2:])
            return
        endless = command.startswith("curl -N")
        if self.server is not None:
            command = _ADDRESS.sub(self.server.url, command)
        if command.startswith("skiros run ") and "--fake" not in command:
            command += " --fake"  # physics is for tests/scenario
        script = f'curl() {{ command curl -sS --fail-with-body --max-time {2 if endless else 30} "$@"; }}\n{command}'
        done = subprocess.run(
            ["bash", "-c", script], cwd=self.folder, env=self.environment, capture_output=True, text=True, check=False
        )
        output = done.stdout + done.stderr
        refused = any(line.startswith(("skiros: ", "; no plan")) for line in shown)
        if not endless and (done.returncode != 0) != refused:
            self.faults.append(f"{command}\nended with {done.returncode}:\n{output}")
        words = {
            word
            for line in ([] if endless else shown)
            for word in re.findall(r"(?<![\w/.-])[A-Za-z_]{4,}(?![\w/.-])", line)
        }
        if missing := sorted(word for word in words if word.lower() not in output.lower()):
            self.faults.append(f"{command}\ndoes not show {missing}, but\n{output}")

    def serve(self, arguments: list[str]) -> None:
        """Starts a server as shown, without physics and at any port, and ends it."""
        at = arguments.index("--data") + 1
        if self.server is not None and (self.folder / arguments[at]).resolve() == self.server.data.resolve():
            arguments[at] = "another"
        data = self.folder / arguments[at]
        del arguments[at - 1 : at + 1]
        if "--port" in arguments:
            del arguments[arguments.index("--port") : arguments.index("--port") + 2]
        with ServerProcess(*arguments, "--fake", data=data) as server:
            server.end()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    folder = tmp_path_factory.mktemp("docs")
    with ServerProcess("kitting", "--fake", "--pace", "max", data=folder / "work") as process:
        subprocess.run(
            [sys.executable, "-m", "skiros_py.cli", "world", "create", "kitting", "--data", folder / "plant"],
            check=True,
        )
        shutil.copy(ROOT / "scenes" / "kitting.ttl", folder / "my_cell.ttl")
        yield process


def shows_something_to_run(page: Path) -> bool:
    return name(page) not in ELSEWHERE and any(
        kind(language, text) in ("shell", "http") for language, text in blocks(page)
    )


def is_of_server(page: Path) -> bool:
    return page.parent.name == "rest" or page.name in ("rest.md", "README.md")


SERVED = sorted((page for page in PAGES if is_of_server(page)), key=lambda page: (page.name not in FIRST, page))


@pytest.mark.parametrize("page", [page for page in SERVED if shows_something_to_run(page)], ids=lambda page: page.name)
def test_what_the_pages_about_the_server_show_works(page: Path, server: ServerProcess) -> None:
    reader = Reader(server.data.parent, server)
    if page.name not in FIRST:
        fresh(server)

    for language, text in blocks(page):
        reader.read(language, text)

    assert not reader.faults, "\n@@".join(f[:700] for f in reader.faults)


def fresh(server: ServerProcess) -> None:
    """Waits until no job is under way, and loads the scene again."""
    with Client(server.url, None) as client:
        for job in client.jobs.list().items:
            if job.outcome is None:
                client.jobs.wait(job.id, timeout=60.0)
    for _ in range(100):
        answer = httpx2.put(
            f"{server.url}/api/v1/scene", json={"name": "kitting"}, headers={"If-Match": "*"}, timeout=60
        )
        if answer.status_code != 409:
            break
        time.sleep(0.1)
    assert not answer.is_error, answer.text


OTHERS = [page for page in PAGES if not is_of_server(page) and shows_something_to_run(page)]


@pytest.mark.parametrize("page", OTHERS, ids=lambda page: page.name)
def test_commands_of_the_other_pages_work_as_shown(page: Path, tmp_path: Path) -> None:
    reader = Reader(tmp_path)

    for language, text in blocks(page):
        reader.read(language, text)

    assert not reader.faults, "\n@@".join(f[:700] for f in reader.faults)


def test_whatever_is_not_run_is_still_shown() -> None:
    shown = "\n".join(text for page in PAGES for _, text in blocks(page))

    assert [start for start in NOT_RUN if start.strip() not in shown] == []
    assert set(ELSEWHERE) <= {name(page) for page in PAGES}


def test_no_page_hides_an_example_from_the_tests() -> None:
    hidden = [
        f"{page.name}: {text[:60]}"
        for page in PAGES
        for language, text in blocks(page)
        if language != "python" and re.match(r"(from|import|with) \w", text) and page.name != "rules.md"
    ]

    assert hidden == []
