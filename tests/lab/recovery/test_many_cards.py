"""A plan of a hand card keeps its word."""

import json

import numpy as np
from tests.calibration.hand_cards import KT, STEPS, make_card

from pitotbench.calibration.hand_card import reduce_card
from pitotbench.cli.app import main


def test_a_plan_by_hand_keeps_its_word(capsys):
    """The shortest card for the wanted bound; flown cards of its form have such a bound."""
    assert main(["plan", "--by-hand", "--speeds-kt", "75,145", "--want-kt", "1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    fly, cards = answer["fly"], answer["cards"]
    assert fly["two_sigma_kt"] <= 1.0
    assert all(card["two_sigma_kt"] > 1.0 for card in cards if card["minutes"] < fly["minutes"])
    five = [make_card(seed, legs=4, points=5) for seed in range(3001, 3011)]
    curves = [reduce_card(card.legs, STEPS).curves["clean"] for card in five]
    flown = np.mean([curve.two_sigma.mean() / KT for curve in curves])
    planned = [card["two_sigma_kt"] for card in cards if 35.0 <= card["minutes"] <= 40.0]
    assert planned
    assert 0.6 * planned[-1] < flown < 1.6 * planned[-1]
