"""The table of claims. A new claim is a function on the page of its family, and one line here."""

from pitotbench.catalog import Catalog
from pitotlab.study.claims.models import AIRPLANE, BIAS, SAME
from pitotlab.study.claims.motion import DOWN, TURNS
from pitotlab.study.claims.ranking import QUARTER, RANKING, RATINGS, TIMES
from pitotlab.study.claims.sampling import DENSER, FAST, FEWER, SLOW
from pitotlab.study.questions import Claim as Claim
from pitotlab.study.questions import Finding as Finding

_TABLE = (
    TIMES,
    RANKING,
    FAST,
    SLOW,
    BIAS,
    SAME,
    DOWN,
    TURNS,
    DENSER,
    FEWER,
    RATINGS,
    AIRPLANE,
    QUARTER,
)

CLAIMS: Catalog[Claim] = Catalog("claim", {claim.number: claim for claim in _TABLE})
