"""Hand cards by the hundred: their errors have the size of their bounds, and a plan keeps its word."""

import json

import numpy as np
from tests.calibration.hand_cards import KT, STEPS, make_card

from pitotbench.calibration.hand_card import reduce_card
from pitotbench.cli.app import main


def test_errors_have_the_size_of_their_bounds():
    """Thirty cards, half of three legs a point and half of four; the laboratory counts two hundred."""
    errors, shares = [], []
    for seed in range(4001, 4031):
        card = make_card(seed, legs=3 + seed % 2)
        found = reduce_card(card.legs, STEPS)
        assert not found.slips
        for point in found.points:
            error = point.correction / KT - card.correction_kt(point.indicated_airspeed / KT)
            errors.append(error / (point.two_sigma / KT))
        curve = found.curves["clean"]
        error = curve.correction / KT - np.array(
            [card.correction_kt(v / KT) for v in curve.indicated_airspeed]
        )
        shares.append(error / (curve.two_sigma / KT))
    assert len(errors) == 150
    assert (
        0.4 < np.sqrt(np.mean(np.square(errors))) < 0.6
    )  # 0.5 for a true 2σ; the points of a card err together
    assert 0.4 < np.sqrt(np.mean(np.square(shares))) < 0.6


def test_a_plan_by_hand_keeps_its_word(capsys):
    """The shortest card for the wanted bound; flown cards of its form have such a bound."""
    assert main(["plan", "--by-hand", "--speeds-kt", "75,145", "--want-kt", "1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    fly, cards = answer["fly"], answer["cards"]
    assert fly["two_sigma_kt"] <= 1.0
    assert all(card["two_sigma_kt"] > 1.0 for card in cards if card["minutes"] < fly["minutes"])
    five = [make_card(seed, legs=4, points=5) for seed in range(3001, 3011)]
    flown = np.mean(
        [reduce_card(card.legs, STEPS).curves["clean"].two_sigma.mean() / KT for card in five]
    )
    planned = [card["two_sigma_kt"] for card in cards if 35.0 <= card["minutes"] <= 40.0]
    assert planned
    assert 0.6 * planned[-1] < flown < 1.6 * planned[-1]
