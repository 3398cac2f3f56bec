"""All flights of a study, the longest first, so that no process waits for another at the end."""

from dataclasses import replace

from pitotbench.evidence.study.settings import Sortie, claim_sorties
from pitotbench.evidence.study.sweeps import SWEEPS
from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

EXPLAINED = 5  # of so many seeds one also flies what explains, and the sweeps


def plan_sorties(seeds: int, sweeps: bool = True) -> list[Sortie]:
    """The sorties of seeds 1 to `seeds`: the claims for all, for a fifth of them the experiments that explain and,
    where asked for, the sweeps."""
    flown: list[Sortie] = []
    for seed in range(1, seeds + 1):
        rare = seed <= -(-seeds // EXPLAINED)
        flown += [_swept(sortie) if rare and sweeps else sortie for sortie in claim_sorties(seed, rare)]
        if rare and sweeps:
            flown += [extra for sweep in SWEEPS.values() for extra in sweep.sorties(seed)]
    return sorted(flown, key=lambda sortie: -(MANEUVERS[sortie.case.maneuver].minutes or 0.0))


def _swept(sortie: Sortie) -> Sortie:
    """A flight in light turbulence is also looked at by the sweeps."""
    usual = sortie.setting == "light" and sortie.variant == "standard"
    if not usual or sortie.case.maneuver not in PAPER_MANEUVERS:
        return sortie
    more = tuple(look for sweep in SWEEPS.values() for look in sweep.looks(sortie.case.maneuver))
    return replace(sortie, looks=(*sortie.looks, *more))
