"""The tables and keys that a mapping file may hold. Only a mapping loads this file: pydantic is slow to load."""

from pydantic import BaseModel, ConfigDict


class Target(BaseModel):
    """Our column for one of theirs: value = theirs * factor + offset."""

    model_config = ConfigDict(extra="forbid", strict=False)
    name: str
    factor: float = 1.0
    offset: float = 0.0


class File(BaseModel):
    """One file of a log: its name pattern, how it joins the time base, its columns."""

    model_config = ConfigDict(extra="forbid")
    file: str = "*"
    join: str = "last"
    columns: dict[str, str | Target]


class Document(BaseModel):
    """A whole mapping file: either `columns` or `files`."""

    model_config = ConfigDict(extra="forbid")
    title: str = ""
    columns: dict[str, str | Target] = {}
    files: list[File] = []
    calibrate: dict[str, str | float | bool | dict[str, float]] = {}
