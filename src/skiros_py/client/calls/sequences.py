"""Sequences of steps: editing and running."""

from __future__ import annotations

from typing import Any

from skiros_py.api.tasks import InsertStep, NewSequence, RunSequence, SequenceInfo, Sequences, TaskInfo, WantedStep
from skiros_py.client.request import Call, if_match, nothing, path_of


def list_sequences() -> Call[Sequences]:
    """Lists the sequences, by id."""
    return Call("GET", "/sequences", Sequences)


def create_sequence(sequence: NewSequence) -> Call[SequenceInfo]:
    """Creates a sequence from steps, from a plan for a goal, or from the plan of a job, a task or a preview."""
    body = sequence.model_dump(mode="json", exclude_none=True)
    return Call("POST", "/sequences", SequenceInfo, json=body, repeatable=False)


def get_sequence(sequence: str) -> Call[SequenceInfo]:
    """Returns a sequence with every step checked against the current world."""
    return Call("GET", path_of("sequences", sequence), SequenceInfo)


def delete_sequence(sequence: str, version: int) -> Call[None]:
    """Deletes a sequence, if it has the given version."""
    return Call("DELETE", path_of("sequences", sequence), nothing, headers=if_match(version), repeatable=False)


def insert_step(sequence: str, version: int, step: InsertStep) -> Call[SequenceInfo]:
    """Adds a step before another one, or at the end."""
    return _edit(
        "POST", path_of("sequences", sequence, "steps"), version, step.model_dump(mode="json", exclude_none=True)
    )


def change_step(sequence: str, version: int, number: int, step: WantedStep) -> Call[SequenceInfo]:
    """Replaces a step, by its index from 0."""
    return _edit("PUT", path_of("sequences", sequence, "steps", number), version, step.model_dump(mode="json"))


def remove_step(sequence: str, version: int, number: int) -> Call[SequenceInfo]:
    """Removes a step, by its index from 0."""
    return _edit("DELETE", path_of("sequences", sequence, "steps", number), version, None)


def move_step(sequence: str, version: int, number: int, to: int) -> Call[SequenceInfo]:
    """Moves a step to another index."""
    return _edit("POST", path_of("sequences", sequence, "steps", number, "move"), version, {"to": to})


def run_sequence(sequence: str, how: RunSequence | None = None) -> Call[TaskInfo]:
    """Runs the steps as they are, once or repeatedly; returns the task that runs them."""
    body = RunSequence.model_validate({} if how is None else how).model_dump(mode="json")
    path = path_of("sequences", sequence, "run")
    return Call("POST", path, TaskInfo, json=body, repeatable=False)


def _edit(method: str, path: str, version: int, body: Any) -> Call[SequenceInfo]:
    return Call(method, path, SequenceInfo, json=body, headers=if_match(version), repeatable=False)
