"""A drafted mapping as TOML, with what is sure and what is to be checked beside each line."""

import json

import tomli_w

from pitotbench.logbook.drafting.draft_mapping import DraftedLine, DraftedMapping

_SHOWN = 40  # columns left over that are listed


def mapping_text(drafted: DraftedMapping, log: str) -> str:
    """Return the TOML text of a mapping for the log of a name."""
    open_lines = sum(bool(line.question) for line in drafted.lines)
    log = " ".join(log.split())
    above = [f"# Drafted from {log}: {len(drafted.lines)} columns recognized, {open_lines} to be checked."]
    above += [f"# No column was found for {name}: add a line." for name in drafted.missing]
    if drafted.refusal:
        above.append(f"# With these lines the log is refused: {' '.join(drafted.refusal.split())}")
    body = [_line(line) for line in drafted.lines]
    unused = [" ".join(name.split()) for name in drafted.unused if name][
        :_SHOWN
    ]  # a line break would end the comment
    below = [f"# Not used: {', '.join(unused)}"] if unused else []
    title = tomli_w.dumps({"title": f"drafted from {log}"}).strip()
    return "\n".join([*above, title, "", "[columns]", *body, "", *below]).rstrip() + "\n"


def _line(line: DraftedLine) -> str:
    guess = line.guess
    target = guess.target(line.unit)
    value = json.dumps(target) if guess.factor == 1.0 else f'{{ name = "{target}", factor = {guess.factor!r} }}'
    return f"{json.dumps(guess.theirs, ensure_ascii=False)} = {value}  # {line.question or 'sure'}"
