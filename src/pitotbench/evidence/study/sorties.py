"""All flights of a study, the longest first, so that no process waits for another at the end."""

from dataclasses import replace

from pitotbench.evidence.study.settings import Sortie, claim_sorties
from pitotbench.evidence.study.sweeps import SWEEPS
from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

EXPLAINED = 5  # one of this many seeds also flies the rare settings and the sweeps


def plan_sorties(seeds: int, sweeps: bool = True) -> list[Sortie]:
    """Return the sorties of seeds 1 to `seeds`.

    All seeds fly the sorties of the claims. A fifth of them also fly the experiments that explain and, with
    `sweeps`, the sweeps.
    """
    flown: list[Sortie] = []
    for seed in range(1, seeds + 1):
        rare = seed <= -(-seeds // EXPLAINED)
        flown += [_swept(sortie) if rare and sweeps else sortie for sortie in claim_sorties(seed, rare)]
        if rare and sweeps:
            flown += [extra for sweep in SWEEPS.values() for extra in sweep.sorties(seed)]
    return sorted(flown, key=lambda sortie: -(MANEUVERS[sortie.case.maneuver].minutes or 0.0))


def _swept(sortie: Sortie) -> Sortie:
    """Return the sortie with the looks of the sweeps added where it is in light turbulence."""
    usual = sortie.setting == "light" and sortie.variant == "standard"
    if not usual or sortie.case.maneuver not in PAPER_MANEUVERS:
        return sortie
    more = tuple(look for sweep in SWEEPS.values() for look in sweep.looks(sortie.case.maneuver))
    return replace(sortie, looks=(*sortie.looks, *more))
