"""The sheet to print and fill in on the knee: one row a leg, with the columns of a points table."""

from pitotbench.show.markup import render


def card_sheet(points: int = 6, legs: int = 4) -> str:
    """The HTML of an empty sheet, which prints on one page."""
    return render("sheet.html", points=points, legs=legs)
