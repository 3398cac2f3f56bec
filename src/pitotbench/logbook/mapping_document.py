"""The tables and keys that a mapping file may hold. Only a mapping loads this file: pydantic is slow to load."""

from pydantic import BaseModel, ConfigDict


class Target(BaseModel):
    """Our column for one of theirs: value = theirs * factor + offset."""

    model_config = ConfigDict(extra="forbid", strict=False)
    name: str
    factor: float = 1.0
    offset: float = 0.0
    optional: bool = False


class File(BaseModel):
    """One file of a log: its name pattern, how it joins the time base, its columns."""

    model_config = ConfigDict(extra="forbid")
    file: str | list[str] = "*"
    join: str = "last"
    optional: bool = False
    columns: dict[str, str | Target]


class Document(BaseModel):
    """A whole mapping file: either `columns` or `files`."""

    model_config = ConfigDict(extra="forbid")
    title: str = ""
    recognize: list[str] = []
    columns: dict[str, str | Target] = {}
    files: list[File] = []
    calibrate: dict[str, str | float | bool | dict[str, float]] = {}
