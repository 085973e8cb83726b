"""The reference is what the code says, and has every public name of what authors use."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "reference"


def generator() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_reference", FOLDER / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MAKE: Any = generator()


@pytest.mark.parametrize("name", MAKE.PAGES)
def test_a_page_of_the_reference_is_what_the_code_says(name: str) -> None:
    text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")

    assert text == MAKE.page(*MAKE.PAGES[name]), "python docs/reference/make.py writes it again"
    assert " at 0x" not in text


def own_of(thing: Any) -> list[tuple[str, Any]]:
    return list(vars(thing).items()) if isinstance(thing, type) else []


@pytest.mark.parametrize("name", MAKE.PAGES)
def test_every_public_name_and_method_is_on_its_page(name: str) -> None:
    lines = (FOLDER / f"{name}.md").read_text(encoding="utf-8").splitlines()

    for content in MAKE.PAGES[name][1]:
        for own, thing in MAKE.names_of(content):
            assert f"## {own}" in lines
            methods = [key for key, value in own_of(thing) if callable(value) and not isinstance(value, type)]
            new = [key for key in methods if not any(hasattr(base, key) for base in thing.__mro__[1:])]
            for method in (key for key in new if not key.startswith("_") and getattr(thing, key).__doc__):
                assert f"### {own}.{method}" in lines


def test_what_authors_ask_for_is_described() -> None:
    descriptions = (FOLDER / "descriptions.md").read_text(encoding="utf-8")
    world = (FOLDER / "world.md").read_text(encoding="utf-8")

    assert "- `hold`: Must hold while it runs." in descriptions
    assert "- `abstract`: True when a goal may give a class" in descriptions
    assert "### Transaction.set" in world
