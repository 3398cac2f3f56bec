"""Strict JSON, which every parser accepts: no NaN and no Infinity."""

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any


def json_text(document: object) -> str:
    """A document of mappings, sequences, text and numbers as strict JSON (RFC 8259), ending in a line break.

    A number that is not finite becomes null, because JSON cannot write it. Raises TypeError for anything else that
    JSON cannot hold.
    """
    return json.dumps(_finite(document), indent=1, allow_nan=False) + "\n"


def _finite(value: object) -> Any:
    if isinstance(value, float) and not isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value
