"""Clients that foreign generators make of the OpenAPI description: they can be imported, and get typed problems."""

from __future__ import annotations

import compileall
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.serving import Served, serving

from skiros_py.server.app import create_app

MINUTES = 10
"""How long a generator may take on a loaded machine."""

OWN = ["factory.api.operation.get_health", "factory.api.operation.get_readiness"]
"""Operations whose only other answer is of their own type, not a problem."""

IMPORTS = """
import importlib, json, pkgutil, sys

sys.path.insert(0, sys.argv[1])
import factory

modules = [importlib.import_module(one.name) for one in pkgutil.walk_packages(factory.__path__, "factory.")]
untyped = [
    one.__name__
    for one in modules
    if hasattr(one, "sync_detailed") and "ProblemDetails" not in str(one.sync_detailed.__annotations__["return"])
]
"""
CALLS = """
from factory.api.jobs import get_job, list_jobs, put_job
from factory.models import JobOrder, ProblemDetails

client = factory.Client(base_url=sys.argv[2])
accepted = put_job.sync("kit-1", client=client, body=JobOrder(goal="InKit(Starter, kit_1)"), start=False)
refused = put_job.sync("kit-2", client=client, body=JobOrder(goal="Nonsense("))
missing = get_job.sync("kit-3", client=client)
assert isinstance(refused, ProblemDetails) and isinstance(missing, ProblemDetails)
print(json.dumps({
    "untyped": untyped,
    "accepted": accepted.state.text,
    "refused": [refused.status, refused.code],
    "missing": [missing.status, missing.code],
    "listed": [job.id for job in list_jobs.sync(client=client).items],
}))
"""


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture
def described(served: Served, tmp_path: Path) -> Path:
    path = tmp_path / "openapi.json"
    path.write_text(json.dumps(create_app(served.services).openapi()))
    return path


def run(*command: object) -> str:
    done = subprocess.run(
        [sys.executable, *map(str, command)], capture_output=True, text=True, timeout=MINUTES * 60, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@pytest.mark.timeout(4 * MINUTES * 60)
def test_a_generated_client_orders_jobs_and_gets_typed_problems(
    served: Served, described: Path, tmp_path: Path
) -> None:
    options = tmp_path / "options.yaml"
    options.write_text("post_hooks: []\n")
    folder = tmp_path / "factory"
    run("-m", "openapi_python_client", "generate", "--path", described, "--output-path", folder, "--meta", "none",
        "--config", options)  # fmt: skip
    assert compileall.compile_dir(folder, quiet=1)

    said = json.loads(run("-c", IMPORTS + CALLS, tmp_path, served.url))

    assert said == {
        "untyped": OWN,
        "accepted": "NotAllowedToStart",
        "refused": [422, "GoalSyntax"],
        "missing": [404, "UnknownJobOrderID"],
        "listed": ["kit-1"],
    }


@pytest.mark.timeout(4 * MINUTES * 60)
def test_generated_models_have_every_schema_and_read_problems(described: Path, tmp_path: Path) -> None:
    made = tmp_path / "models.py"
    run("-m", "datamodel_code_generator", "--input", described, "--input-file-type", "openapi", "--output", made,
        "--output-model-type", "pydantic_v2.BaseModel", "--formatters", "builtin")  # fmt: skip
    problem: dict[str, Any] = {"title": "Goal syntax", "status": 422, "code": "GoalSyntax", "column": 3}
    script = (
        "import json, sys; sys.path.insert(0, sys.argv[1]); import models;"
        " problem = models.ProblemDetails.model_validate_json(sys.argv[2]);"
        " print(json.dumps([problem.code, problem.column, sorted(vars(models))]))"
    )

    code, column, names = json.loads(run("-c", script, tmp_path, json.dumps(problem)))

    assert (code, column) == ("GoalSyntax", 3)
    schemas = json.loads(described.read_text())["components"]["schemas"]
    assert {name.replace("_", "") for name in schemas} <= {name.replace("_", "") for name in names}
