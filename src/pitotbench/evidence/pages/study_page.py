"""The study as a page and as a Markdown document with its pictures as files."""

from pathlib import Path

import pandas as pd

from pitotbench.evidence.pages.charts import draw, save
from pitotbench.evidence.pages.study_parts import Part, StudyPage
from pitotbench.logbook import write_text
from pitotbench.show.columns import frame_columns, frame_rows, html_table, markdown_table
from pitotbench.show.markup import render


def study_html(page: StudyPage) -> str:
    """One self-contained page."""
    groups = [
        ("Claims", page.claims),
        ("What the residual does not show", page.truth),
        ("Open questions", page.questions),
    ]
    groups = [(name, parts) for name, parts in groups if parts]
    shown = [
        (
            name,
            [
                (part, [draw(chart) for chart in part.charts], [_html(table) for table in part.tables])
                for part in parts
            ],
        )
        for name, parts in groups
    ]
    return render("study.html", page=page, groups=shown, summary=_html(page.summary))


def _html(table: pd.DataFrame) -> str:
    return html_table(frame_columns(table), frame_rows(table))


def _markdown(table: pd.DataFrame) -> str:
    return markdown_table(frame_columns(table), frame_rows(table))


def write_document(page: StudyPage, folder: Path) -> Path:
    """`study.md` in a folder and its pictures in `study/`; returns the document's path."""
    pictures = folder / "study"
    pictures.mkdir(parents=True, exist_ok=True)
    blocks = [f"# {page.title}", page.subtitle, *page.short, _markdown(page.summary)]
    for heading, parts in (
        ("The claims, one by one", page.claims),
        ("What the residual does not show", page.truth),
        ("What the paper left open", page.questions),
    ):
        blocks += [f"## {heading}"] if parts else []
        for part in parts:
            blocks += _part(part, pictures)
    blocks += ["## How it was done", *page.method]
    target = folder / "study.md"
    write_text(target, "\n\n".join(blocks) + "\n")
    return target


def _part(part: Part, pictures: Path) -> list[str]:
    blocks = [f"### {part.heading}: {part.verdict}" if part.verdict else f"### {part.heading}"]
    blocks += [f"**{label}:** {text}" if label else text for label, text in part.lines]
    for chart in part.charts:
        name = f"{chart.name}.png"
        save(chart, pictures / name)
        blocks.append(f"![{chart.title}](study/{name})\n*{f'{chart.title}. {chart.note}'.rstrip('. ')}*")
    return blocks + [_markdown(table) for table in part.tables]
