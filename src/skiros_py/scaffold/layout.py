"""Where the files of a package lie."""

from __future__ import annotations

from skiros_py.scaffold.project import Project

_FOLDERS = {
    "conditions": "The words in which goals and skills are stated, one in a file.",
    "primitives": "What a robot does, one in a file.",
    "skills": "What can be planned, one in a file.",
}


def folder_files(project: Project, folder: str) -> dict[str, str]:
    """Returns what makes a folder a Python package, by path; nothing where it is one already."""
    path = f"src/{project.package}/{folder}/__init__.py"
    return {} if (project.root / path).exists() else {path: f'"""{_FOLDERS[folder]}"""\n'}
