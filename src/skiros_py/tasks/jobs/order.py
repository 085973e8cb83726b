"""What is ordered: a goal, with what somebody's own system says about it."""

from __future__ import annotations

from typing import Annotated

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, field_validator

from skiros_py.tasks.policy import Policy

_LONGEST_ID = 200
_PRIORITIES = 2**15


class Material(BaseModel):
    """Parts that an order is about (ISA-95: material requirement), as whoever orders says it.

    Attributes:
        class_: Their class; "class" in JSON.
        definition: Number of the material, where whoever orders has one.
        lot: The lot that they shall be of.
        quantity: How many pieces; or an amount, a decimal number as text.
        units: Of the amount; empty for pieces.
        id: Which piece, where just that one is meant.
        location: Where it shall be used.
        use: What for.
        properties: What else whoever orders says of them.
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
    """What is ordered (ISA-95: job order).

    Attributes:
        id: Chosen by whoever orders; the same order again is the same job.
        goal: Goal texts; all must hold together.
        description: For people.
        priority: The higher comes first.
        not_before: The start gate: it does not start earlier. None for at once.
        deadline: When it should be done; of equal priority the earlier comes first. A job that is late is still done,
            and says so, unless ``expires``.
        expires: True where it must not be begun after its deadline.
        policy: What happens when something of the goal cannot be reached.
        work_master: Name of the goal template that the goal was made of; empty where it was stated as it is.
        parameters: What the template was given, by the names of its parameters.
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
