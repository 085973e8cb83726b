from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINT = Path(sys.executable).parent / "lint-imports"


def _contracts() -> list[str]:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings.get("tool", {}).get("importlinter", {}).get("contracts", [])
    return [contract.get("id", contract["name"]) for contract in contracts]


@pytest.mark.skipif(not LINT.is_file(), reason="import-linter is not installed (dependency group lint)")
@pytest.mark.skipif(not _contracts(), reason="pyproject.toml has no import contracts yet")
def test_every_import_contract_is_kept() -> None:
    result = subprocess.run([str(LINT), "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)

    assert result.returncode == 0, result.stdout + result.stderr
