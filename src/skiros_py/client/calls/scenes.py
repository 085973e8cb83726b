"""Scenes: those that can be loaded, and the present one."""

from __future__ import annotations

from skiros_py.api.scenes import PresentScene, Scene, SceneDifference, SceneEntry, Scenes
from skiros_py.client.call import Call, if_match, nothing, path_of


def list_scenes(*, limit: int = 100, cursor: str | None = None) -> Call[Scenes]:
    """Lists the scenes that can be loaded, by name."""
    return Call("GET", "/scenes", Scenes, query={"limit": limit, "cursor": cursor})


def get_scene_file(name: str) -> Call[Scene]:
    """Returns what a scene consists of, without loading it."""
    return Call("GET", path_of("scenes", name), Scene)


def save_scene(name: str, *, version: int | None = None) -> Call[SceneEntry]:
    """Saves the present scene.

    Args:
        name: Under which name.
        version: The version of the saved scene of that name that it replaces; None if it shall be a new one.
    """
    return Call(
        "POST",
        "/scenes",
        SceneEntry,
        json={"name": name},
        headers=if_match(version),
        repeatable=False,
    )


def delete_scene(name: str, *, version: int | None = None) -> Call[None]:
    """Removes a saved scene; where a version is given, only that one."""
    return Call("DELETE", path_of("scenes", name), nothing, headers=if_match(version))


def get_scene() -> Call[PresentScene]:
    """Tells about the present scene."""
    return Call("GET", "/scene", PresentScene)


def load_scene(name: str, *, version: int | None = None) -> Call[PresentScene]:
    """Makes the present scene another one; it is answered when the station is up in it.

    Args:
        name: Its name.
        version: The version of the world that you have seen; None for any.
    """
    headers = if_match(version, "*")
    return Call("PUT", "/scene", PresentScene, json={"name": name}, headers=headers, repeatable=False)


def upload_scene(turtle: str, *, version: int | None = None) -> Call[PresentScene]:
    """Makes the present scene the one that a Turtle text describes; see :func:`load_scene`."""
    headers = {**if_match(version, "*"), "Content-Type": "text/turtle"}
    return Call("PUT", "/scene", PresentScene, content=turtle.encode(), headers=headers, repeatable=False)


def get_scene_turtle() -> Call[str]:
    """Returns the present scene as Turtle."""
    return Call("GET", "/scene.ttl", lambda r: r.text)


def get_scene_difference(name: str, *, limit: int = 100, cursor: str | None = None) -> Call[SceneDifference]:
    """Returns what makes the present scene of another one."""
    query = {"with": name, "limit": limit, "cursor": cursor}
    return Call("GET", "/scene/diff", SceneDifference, query=query)
