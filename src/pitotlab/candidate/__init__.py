"""A candidate for the calibration: one linear-Gaussian problem in place of nested mixtures.

It is judged beside the product on equal logs (`outside judge --candidate`) and takes the product's
place, or goes. It reads measured logs; the published laws, faulty rows across long flights, and
displays that round are still the product's alone. `python -m pitotlab outside compare` shows both.
"""

from pitotlab.candidate.answer import CandidateAnswer as CandidateAnswer
from pitotlab.candidate.answer import calibrate as calibrate
