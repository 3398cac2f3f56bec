"""Coverage of the bounds of hand-written cards, counted.

python -m tests.lab.hand_card_figures --first 4001 --cards 200 Half of the cards have three legs a
point, half four. Cards are made by `hand_cards`, whose formulas are their own.
"""

import argparse
from dataclasses import dataclass

import numpy as np
from tests.calibration.hand_cards import KT, STEPS, make_card, make_mixed_card, with_slips

from pitotbench.calibration.hand_card import reduce_card


@dataclass(frozen=True)
class Coverage:
    """Errors and bounds [kt] of points, (p,), and curves, (c, v); the legs called a slip."""

    point_errors: np.ndarray
    point_bounds: np.ndarray
    curve_errors: np.ndarray
    curve_bounds: np.ndarray
    slips: int

    @property
    def points_inside(self) -> float:
        """Share of the points whose error is within 2σ."""
        return float(np.mean(self.point_errors < self.point_bounds))

    @property
    def curves_inside(self) -> float:
        """The same of the airspeeds of all curves."""
        return float(np.mean(self.curve_errors < self.curve_bounds))


def coverage(first: int, cards: int) -> Coverage:
    """Reduce cards of the seeds from `first` on, and hold their corrections against the truth."""
    points, curves, slips = [], [], 0
    for seed in range(first, first + cards):
        card = make_card(seed, legs=3 + seed % 2)
        found = reduce_card(card.legs, STEPS)
        slips += len(found.slips)
        for point in found.points:
            if point.correction is not None:
                error = point.correction / KT - card.correction_kt(point.indicated_airspeed / KT)
                points.append((abs(error), point.two_sigma / KT))
        curve = found.curves["clean"]
        truth = np.array([card.correction_kt(v / KT) for v in curve.indicated_airspeed])
        curves.append((np.abs(curve.correction / KT - truth), curve.two_sigma / KT))
    return Coverage(*np.array(points).T, *map(np.array, zip(*curves, strict=True)), slips)


@dataclass(frozen=True)
class Slips:
    """Counts over cards of 81 rows with six slips each: slips, those found, legs called a slip that
    are none, and legs that are right; points without an answer; errors and bounds [kt] of the
    curves.
    """

    written: int
    found: int
    false: int
    right: int
    lost: int
    errors: np.ndarray
    bounds: np.ndarray


def slips_found(first: int, cards: int) -> Slips:
    """Reduce spoiled cards of the seeds from `first` on."""
    written = found = false = right = lost = 0
    curves = []
    for seed in range(first, first + cards):
        legs, truth = make_mixed_card(seed)
        spoiled, rows = with_slips(legs, seed, 6)
        answer = reduce_card(spoiled, STEPS)
        named = {slip.row for slip in answer.slips}
        written, found = written + len(rows), found + len(rows & named)
        false, right = false + len(named - rows), right + len(legs) - len(rows)
        lost += sum(point.correction is None for point in answer.points if point.legs >= 3)
        for name, curve in answer.curves.items():
            meant = np.array([truth[name](v / KT) for v in curve.indicated_airspeed])
            curves.append((np.abs(curve.correction / KT - meant), curve.two_sigma / KT))
    errors, bounds = (np.array(each) for each in zip(*curves, strict=True))
    return Slips(written, found, false, right, lost, errors, bounds)


def main() -> None:
    """Print the figures of docs/fixed-speed.md."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--first", type=int, default=4001, help="first seed")
    parser.add_argument("--cards", type=int, default=200)
    options = parser.parse_args()
    found = coverage(options.first, options.cards)
    spoiled = slips_found(options.first, options.cards // 5)
    for what, errors, bounds in (
        ("points", found.point_errors, found.point_bounds),
        ("curves", found.curve_errors, found.curve_bounds),
        ("curves of spoiled cards", spoiled.errors, spoiled.bounds),
    ):
        rms = float(np.sqrt(np.mean(errors**2)))
        inside = f"{np.mean(errors < bounds):.1%} inside 2σ"
        sizes = f"mean 2σ {np.mean(bounds):.2f} kt, rms error {rms:.2f} kt"
        print(f"{len(errors):,} {what}: {inside}, {sizes}")
    print(f"legs called a slip: {found.slips}")
    slips = f"{spoiled.found} of {spoiled.written} slips found"
    false = f"{spoiled.false} of {spoiled.right} right legs called one"
    print(f"cards of 81 rows with six slips: {slips}, {false}, {spoiled.lost} points lost")


if __name__ == "__main__":
    main()
