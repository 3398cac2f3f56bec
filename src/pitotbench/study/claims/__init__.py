"""The table of claims: a newcomer is one file, or a function in one, and one line here."""

from pitotbench.catalog import Catalog
from pitotbench.study.claims.airplane import AIRPLANE
from pitotbench.study.claims.claim import Claim as Claim
from pitotbench.study.claims.claim import Finding as Finding
from pitotbench.study.claims.density import DENSER, FEWER
from pitotbench.study.claims.down import DOWN, TURNS
from pitotbench.study.claims.effort import RATINGS
from pitotbench.study.claims.ranking import RANKING
from pitotbench.study.claims.rates import FAST, SLOW
from pitotbench.study.claims.structure import BIAS, SAME
from pitotbench.study.claims.times import QUARTER, TIMES

_TABLE = (TIMES, RANKING, FAST, SLOW, BIAS, SAME, DOWN, TURNS, DENSER, FEWER, RATINGS, AIRPLANE, QUARTER)

CLAIMS: Catalog[Claim] = Catalog("claim", {claim.number: claim for claim in _TABLE})
