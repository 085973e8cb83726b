"""Scenes: those that can be loaded, and the current one."""

from __future__ import annotations

from skiros_py.api.scenes import PresentScene, Scene, SceneDifference, SceneEntry, Scenes
from skiros_py.client.request import Call, if_match, nothing, path_of


def list_scenes(*, limit: int = 100, cursor: str | None = None) -> Call[Scenes]:
    """Lists the scenes that can be loaded, by name."""
    return Call("GET", "/scenes", Scenes, query={"limit": limit, "cursor": cursor})


def get_scene_file(name: str) -> Call[Scene]:
    """Returns the contents of a scene without loading it."""
    return Call("GET", path_of("scenes", name), Scene)


def save_scene(name: str, *, version: int | None = None) -> Call[SceneEntry]:
    """Saves the current scene.

    Args:
        name: The name to save it under.
        version: The version of the saved scene that it replaces; None for a new one.
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
    """Removes a saved scene; if a version is given, only that one."""
    return Call("DELETE", path_of("scenes", name), nothing, headers=if_match(version))


def get_scene() -> Call[PresentScene]:
    """Returns the current scene."""
    return Call("GET", "/scene", PresentScene)


def load_scene(name: str, *, version: int | None = None) -> Call[PresentScene]:
    """Loads a scene; returns once the station is up in it.

    Args:
        name: Its name.
        version: The version of the world the caller has seen; None for any.
    """
    headers = if_match(version, "*")
    return Call("PUT", "/scene", PresentScene, json={"name": name}, headers=headers, repeatable=False)


def upload_scene(turtle: str, *, version: int | None = None) -> Call[PresentScene]:
    """Loads a scene from Turtle text; see :func:`load_scene`."""
    headers = {**if_match(version, "*"), "Content-Type": "text/turtle"}
    return Call("PUT", "/scene", PresentScene, content=turtle.encode(), headers=headers, repeatable=False)


def get_scene_turtle() -> Call[str]:
    """Returns the current scene as Turtle."""
    return Call("GET", "/scene.ttl", lambda r: r.text)


def get_scene_difference(name: str, *, limit: int = 100, cursor: str | None = None) -> Call[SceneDifference]:
    """Returns the difference from another scene to the current one."""
    query = {"with": name, "limit": limit, "cursor": cursor}
    return Call("GET", "/scene/diff", SceneDifference, query=query)
