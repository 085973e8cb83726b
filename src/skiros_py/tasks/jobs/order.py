"""A job order: a goal with the data of the ordering system."""

from __future__ import annotations

from typing import Annotated

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, field_validator

from skiros_py.tasks.policy import Policy

_LONGEST_ID = 200
_PRIORITIES = 2**15


class Material(BaseModel):
    """Parts that an order is about (ISA-95: material requirement), as stated by the client.

    Attributes:
        class_: Their class; "class" in JSON.
        definition: The client's material number, if any.
        lot: The required lot.
        quantity: How many pieces; or an amount, a decimal number as text.
        units: Unit of the amount; empty for pieces.
        id: Id of a specific piece, if required.
        location: Where it is to be used.
        use: Its intended use.
        properties: Further properties given by the client.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True)

    class_: str = Field(alias="class")
    definition: str = ""
    lot: str = ""
    quantity: Annotated[int, Field(ge=1)] | str = 1
    units: str = ""
    id: str = ""
    location: str = ""
    use: str = ""
    properties: dict[str, str] = {}


class JobOrder(BaseModel):
    """A job order (ISA-95).

    Attributes:
        id: Chosen by the client; the same order again is the same job.
        goal: Goal texts; all must hold together.
        description: For people.
        priority: Higher values come first.
        not_before: The start gate: it does not start earlier. None for no gate.
        deadline: When it should be done; of equal priority the earlier comes first. A late job is still done and
            marked as late, unless ``expires``.
        expires: True if it must not be started after its deadline.
        policy: What to do when part of the goal is unreachable.
        work_master: Name of the goal template the goal was made from; empty if it was stated directly.
        parameters: The template's arguments by parameter name.
        materials: Which parts were ordered with it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str = Field(min_length=1, max_length=_LONGEST_ID, pattern=r"^[^\s/\x00-\x1f]+$")
    goal: tuple[str, ...] = Field(min_length=1)
    description: str = ""
    priority: int = Field(default=0, ge=-_PRIORITIES, lt=_PRIORITIES)
    not_before: AwareDatetime | None = None
    deadline: AwareDatetime | None = None
    expires: bool = False
    policy: Policy = Policy()
    work_master: str = ""
    parameters: dict[str, str] = {}
    materials: tuple[Material, ...] = ()

    @field_validator("goal", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return (value,) if isinstance(value, str) else value
