"""What differs between two answers: numbers by key and size, texts as lines of a unified diff."""

import math
from collections.abc import Iterator, Mapping
from difflib import unified_diff

OF_TWO_SIGMA = 0.1  # a difference above this share of its own 2σ is a defect
MOST_LINES = 40  # of one text


def differences(before: object, today: object, key: str = "") -> Iterator[str]:
    """Yield a line or some for each difference of two JSON values, with its key."""
    if isinstance(before, Mapping) and isinstance(today, Mapping):
        for name in [*before, *(each for each in today if each not in before)]:
            place = f"{key}.{name}" if key else str(name)
            if name not in before or name not in today:
                side, value = ("today", today[name]) if name in today else ("before", before[name])
                yield f"{place}: only {side}: {_short(value)}"
            elif _is_number(before[name]) and _is_number(today[name]):
                yield from _numbers(before, today, str(name), place)
            else:
                yield from differences(before[name], today[name], place)
    elif isinstance(before, list) and isinstance(today, list):
        if len(before) != len(today):
            yield f"{key}: {len(before)} entries before, {len(today)} today"
        for i, (was, now) in enumerate(zip(before, today, strict=False)):
            yield from differences(was, now, f"{key}[{i}]")
    elif isinstance(before, str) and isinstance(today, str):
        yield from _texts(before, today, key)
    elif not _same(before, today):
        size = f", by {today - before:+.3g}" if _is_number(before) and _is_number(today) else ""  # type: ignore[operator]
        yield f"{key}: {_short(before)} → {_short(today)}{size}"


def _numbers(
    before: Mapping[str, object], today: Mapping[str, object], name: str, key: str
) -> Iterator[str]:
    was, now = before[name], today[name]
    assert isinstance(was, int | float)
    assert isinstance(now, int | float)
    if not _same(was, now):
        bound = _two_sigma(before, name)
        share = abs(now - was) / bound if bound else 0.0
        said = (
            f", {share:.2g} of its 2σ{': A DEFECT' if share > OF_TWO_SIGMA else ''}"
            if bound
            else ""
        )
        yield f"{key}: {was!r} → {now!r}, by {now - was:+.3g}{said}"


def _two_sigma(record: Mapping[str, object], name: str) -> float:
    """Return the 2σ that stands beside a number: `x_kt` has `x_two_sigma_kt` or the record's
    `two_sigma_kt`.
    """
    stem, _, unit = name.rpartition("_")
    first = name.split("_")[0]
    for each in (
        f"{stem}_two_sigma_{unit}",
        f"{name}_two_sigma",
        f"{first}_two_sigma",
        f"two_sigma_{unit}",
        "two_sigma",
    ):
        value = record.get(each)
        if (
            each != name
            and "two_sigma" not in name
            and isinstance(value, int | float)
            and math.isfinite(value)
        ):
            return abs(float(value))
    return 0.0


def _texts(before: str, today: str, key: str) -> Iterator[str]:
    if before == today:
        return
    if "\n" not in before + today:
        yield f"{key}: {before!r} → {today!r}"
        return
    lines = [
        line.rstrip("\n")
        for line in unified_diff(before.splitlines(), today.splitlines(), n=0, lineterm="")
        if not line.startswith(("---", "+++", "@@"))
    ]
    yield f"{key}: {len(lines)} lines differ" if lines else f"{key}: ends of lines differ"
    yield from (f"    {line}" for line in lines[:MOST_LINES])
    if len(lines) > MOST_LINES:
        yield f"    … and {len(lines) - MOST_LINES} more"


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _same(before: object, today: object) -> bool:
    """Return whether two values are the same, bit for bit as JSON has them; no number equals no
    number.
    """
    return type(before) is type(today) and repr(before) == repr(today)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 120 else f"{text[:117]}..."
