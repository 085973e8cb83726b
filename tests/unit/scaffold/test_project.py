"""A package's pyproject.toml: found upwards, read, added to."""

from __future__ import annotations

from importlib.metadata import entry_points
from pathlib import Path

import pytest

from skiros_py.errors import FileError, UsageError
from skiros_py.scaffold.project import Project

TEXT = """\
# Ours.
[project]
name = "my-things"  # as it is called
version = "0.2"
dependencies = [
    "skiros-py>=0.1",  # the platform
]

[project.entry-points."skiros.skills"]
lift = "my_things.lift:LIFT"  # the first

[tool.ruff]
line-length = 100
"""


def package(folder: Path, text: str = TEXT) -> Project:
    (folder / "pyproject.toml").write_text(text, encoding="utf-8")
    (folder / "src" / "my_things").mkdir(parents=True)
    (folder / "src" / "my_things" / "__init__.py").write_text("", encoding="utf-8")
    return Project.around(folder / "src" / "my_things")


def test_a_project_is_found_from_any_folder_inside_it(tmp_path: Path) -> None:
    project = package(tmp_path)

    assert (project.root, project.package, project.name) == (tmp_path, "my_things", "my-things")


def test_adding_an_entry_keeps_every_other_line(tmp_path: Path) -> None:
    before = package(tmp_path)

    after = before.with_entries("skiros.skills", {"drop": "my_things.drop:DROP"})
    after = after.with_entries("skiros.primitives", {"open": "my_things.open:Open"}).with_dependency("other")

    assert after.entry_points == {
        "skiros.skills": {"lift": "my_things.lift:LIFT", "drop": "my_things.drop:DROP"},
        "skiros.primitives": {"open": "my_things.open:Open"},
    }
    assert after.dependencies == ("skiros-py>=0.1", "other")
    lines = iter(after.text.splitlines())
    assert all(line in lines for line in TEXT.splitlines() if line), "each in its order"


def test_an_existing_dependency_is_not_added_twice(tmp_path: Path) -> None:
    project = package(tmp_path)

    assert project.with_dependency("Skiros_Py").draft({}, project).changed == {}
    assert project.with_dependency("my_things").draft({}, project).changed == {}


def test_an_existing_entry_point_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"entry point 'lift' of skiros\.skills already"):
        package(tmp_path).with_entries("skiros.skills", {"lift": "my_things.other:LIFT"})


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[project", "is no TOML"),
        ("[project]\nname = 'x'\n", "no dependency 'skiros-py'"),
        ("[project]\nname = 'x'\ndependencies = 5\n", "no dependency 'skiros-py'"),
        ("project = 5\n", "no dependency 'skiros-py'"),
        ("[tool.x]\n", "no dependency 'skiros-py'"),
    ],
)
def test_a_pyproject_of_another_kind_of_package_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(FileError, match=reason):
        package(tmp_path, text)


def test_outside_a_package_the_error_explains_how_to_create_one(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="skiros new package makes one"):
        Project.around(tmp_path)


def test_a_package_without_its_python_package_is_refused(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text(TEXT, encoding="utf-8")

    with pytest.raises(UsageError, match="one Python package"):
        Project.around(tmp_path)


def test_current_entry_points_of_a_project_take_precedence_over_an_older_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package(tmp_path)
    info = tmp_path / "site" / "my_things-0.1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: My_Things\nVersion: 0.1\n", encoding="utf-8")
    (info / "entry_points.txt").write_text("[skiros.skills]\nold = my_things.old:OLD\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))

    def own() -> set[str]:
        return {e.name for e in entry_points(group="skiros.skills") if e.value.startswith("my_things")}

    assert own() == {"old"}
    with Project.around(tmp_path).as_installed():
        assert own() == {"lift"}
    assert own() == {"old"}
