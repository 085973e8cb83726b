"""Whatever is sent to whatever route: the answer is one that the documentation knows, never a fault of the server."""

import json
import subprocess
import sys
from pathlib import Path

import httpx2
from support.serving import serving

from skiros_py.server.access.roles import Role
from skiros_py.server.settings import ServerSettings

_CHECKS = (
    "not_a_server_error",
    "status_code_conformance",
    "content_type_conformance",
    "response_headers_conformance",
    "response_schema_conformance",
    "use_after_free",
)
_CONFIGURATION = """
[checks.not_a_server_error]
expected-statuses = ["2xx", "3xx", "4xx", 503]
"""
"""That there is too much to do already (503, with Retry-After) is no fault."""
_STREAMS = "events$|stream$"
"""Paths of answers that never end; they have tests of their own."""


def test_no_request_causes_a_server_error_or_an_undocumented_answer(tmp_path: Path) -> None:
    """Examples, edge cases, random requests and sequences of requests, made of the API's own description."""
    with serving("kitting", tmp_path / "data", settings=ServerSettings(rate=1_000_000)) as server:
        _, key = server.services.keys.create("fuzzer", Role.ADMIN)
        header = {"Authorization": f"Bearer {key}"}
        document = (
            httpx2.get(f"{server.url}/api/v1/openapi.json", headers=header, timeout=60.0).raise_for_status().json()
        )
        description = tmp_path / "openapi.json"
        description.write_text(json.dumps(_without_keys(document)), encoding="utf-8")
        configuration = tmp_path / "schemathesis.toml"
        configuration.write_text(_CONFIGURATION, encoding="utf-8")
        command = [sys.executable, "-m", "schemathesis.cli", "--config-file", str(configuration)]
        command += ["run", str(description), "--url", server.url]
        command += ["--phases", "examples,coverage,fuzzing,stateful", "--max-examples", "3", "--seed", "1"]
        command += ["--checks", ",".join(_CHECKS), "--exclude-path-regex", _STREAMS, "--request-timeout", "30"]
        command += ["--header", f"Authorization: Bearer {key}", "--continue-on-failure", "--no-color"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=280, cwd=tmp_path)
        alive = httpx2.get(f"{server.url}/healthz", timeout=60.0).status_code

    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
    assert alive == 200


def _without_keys(document: dict) -> dict:
    """Leaves out how to log in: guessing keys is what the tests of access do, and it soon gets a 429."""
    document.get("components", {}).pop("securitySchemes", None)
    document.pop("security", None)
    for operations in document["paths"].values():
        for operation in operations.values():
            operation.pop("security", None)
    return document
