"""The width of a text, from the widths of its letters: what margins and legends are computed with."""

# Shares of the font size, as in DejaVu Sans; other fonts without serifs are as wide or narrower.
_WIDTHS = {
    0.28: "ijl'IJ", 0.32: " ,.·", 0.35: "/:;|f-\\", 0.40: "()[]t!²r₀", 0.50: "*_`°–szc?\"", 0.57: "LFkvxyP",
    0.62: "TYaoθeéESbdghnpquσρ", 0.64: "$0123456789{}µ√K", 0.69: "AVΔBRXZCU", 0.77: "HNDGOQ&w",
    0.84: "∞#+<=>^~−±×M", 0.97: "%mW@",
}  # fmt: skip
_WIDTH = {letter: width for width, letters in _WIDTHS.items() for letter in letters}
_USUAL = 0.62


def text_width(text: str, size: float) -> float:
    """The width of a line of text at a font size, in the unit of the size."""
    return size * sum(_WIDTH.get(letter, _USUAL) for letter in text)
