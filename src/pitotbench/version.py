"""The version of the project: the metadata of the wheel come from it."""

__version__ = "0.2.0.dev0"
