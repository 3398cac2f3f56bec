"""The table of claims. A new claim is one file, or a function in an existing one, and one line here."""

from pitotbench.catalog import Catalog
from pitotbench.evidence.study.claims.airplane import AIRPLANE
from pitotbench.evidence.study.claims.claim import Claim as Claim
from pitotbench.evidence.study.claims.claim import Finding as Finding
from pitotbench.evidence.study.claims.data_density import DENSER, FEWER
from pitotbench.evidence.study.claims.data_rates import FAST, SLOW
from pitotbench.evidence.study.claims.down import DOWN
from pitotbench.evidence.study.claims.effort import RATINGS
from pitotbench.evidence.study.claims.model_structure import BIAS, SAME
from pitotbench.evidence.study.claims.ranking import RANKING
from pitotbench.evidence.study.claims.times import QUARTER, TIMES
from pitotbench.evidence.study.claims.turns import TURNS

_TABLE = (TIMES, RANKING, FAST, SLOW, BIAS, SAME, DOWN, TURNS, DENSER, FEWER, RATINGS, AIRPLANE, QUARTER)

CLAIMS: Catalog[Claim] = Catalog("claim", {claim.number: claim for claim in _TABLE})
