"""The table of claims. A new claim is a function on the page of its family, and one line here."""

from pitotbench.catalog import Catalog
from pitotlab.study.claims import models, motion, ranking, sampling
from pitotlab.study.questions import Claim

_TABLE = (
    ranking.times,
    ranking.ranking,
    sampling.fast,
    sampling.slow,
    models.bias,
    models.same,
    motion.down,
    motion.turns,
    sampling.denser,
    sampling.fewer,
    ranking.ratings,
    models.airplane,
    ranking.quarter,
)

CLAIMS: Catalog[Claim] = Catalog("claim", {claim.rule.number: claim for claim in _TABLE})
