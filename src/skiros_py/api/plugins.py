"""Plug-ins: what is installed, and what is wrong with it."""

from __future__ import annotations

from pydantic import Field

from skiros_py.api.wire import Answer


class PluginFaultInfo(Answer):
    """What is wrong with a plug-in; it hurts nobody else."""

    name: str = Field(description="Name of the entry point.", examples=["drive"])
    group: str = Field(description="Group of the entry point.", examples=["skiros.skills"])
    distribution: str = Field(description="What brings it, with its version.", examples=["skiros-skills 0.1.0"])
    reason: str = Field(description="What is wrong.", examples=["ModuleNotFoundError: No module named 'cv2'"])
    origin: str = Field(description="File that it is in; empty where nobody knows.", examples=["drive.py"])
    traceback: str = Field(description="Where it was raised; empty where nothing was.", examples=[""])


class PluginInfo(Answer):
    """One entry point."""

    name: str = Field(description="Its name.", examples=["drive"])
    group: str = Field(description="Its group.", examples=["skiros.skills"])
    distribution: str = Field(description="What brings it.", examples=["skiros-skills"])
    version: str = Field(description="Version of that.", examples=["0.1.0"])
    object: str = Field(description="What it names.", examples=["skiros_skills.drive:DRIVE"])
    works: bool = Field(description="True where nothing is wrong with it.")
    faults: list[PluginFaultInfo] = Field(description="What is wrong with it.")


class Plugins(Answer):
    """What is installed."""

    items: list[PluginInfo] = Field(description="All entry points, by group and name.")
    others: list[PluginFaultInfo] = Field(description="Faults that belong to none of them.")
