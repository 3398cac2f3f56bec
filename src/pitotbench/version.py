"""The version of the project: the metadata of the wheel come from it."""

__version__ = "1.0.0"
