from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.plugins import load_plugins

GROUP = "skiros.testing_only"
Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Installs distributions with entry points, as pip would leave them behind."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(name: str, points: dict[str, str], **modules: str) -> None:
        info = tmp_path / f"{name.replace('-', '_')}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n", encoding="utf-8")
        lines = [f"[{GROUP}]", *(f"{key} = {value}" for key, value in points.items())]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        for module, text in modules.items():
            (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")

    return make


def test_plugins_are_loaded_in_the_order_of_their_names(install: Install) -> None:
    install("plug-b", {"zebra": "plug_b:Z", "ant": "plug_b:A"}, plug_b="Z, A = 26, 1")

    plugins, faults = load_plugins(GROUP)

    assert [(p.group, p.name, p.distribution, p.value) for p in plugins] == [
        (GROUP, "ant", "plug-b 1.2", 1),
        (GROUP, "zebra", "plug-b 1.2", 26),
    ]
    assert faults == ()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import no_such_module_anywhere", "ModuleNotFoundError: No module named 'no_such_module_anywhere'"),
        ("def broken(:", "SyntaxError"),
        ("1 / 0", "ZeroDivisionError"),
        ("", "AttributeError"),
    ],
)
def test_a_plugin_that_fails_to_load_is_reported_and_hurts_nobody(install: Install, text: str, reason: str) -> None:
    install("plug-good", {"good": "plug_good:X"}, plug_good="X = 1")
    module = f"plug_bad_{len(text)}"
    install("plug-bad", {"bad": f"{module}:X"}, **{module: text})

    plugins, (fault,) = load_plugins(GROUP)

    assert [p.name for p in plugins] == ["good"]
    assert (fault.group, fault.name, fault.distribution) == (GROUP, "bad", "plug-bad 1.2")
    assert fault.reason.startswith(reason)
    assert fault.traceback.startswith("Traceback (most recent call last)")


def test_a_group_that_nobody_fills_is_empty() -> None:
    assert load_plugins("skiros.nobody_fills_this") == ((), ())
