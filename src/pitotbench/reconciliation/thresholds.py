"""The numbers that decide a verdict, each with its reason.

A change of one of them changes the answers. It needs a new scored set (`python -m pitotlab blind
generate`). "SS" is the sum of squares of the whitened residuals; a fall of the SS by x² has a
significance of x σ.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Thresholds:
    """All limits of a reconciliation.

    A plain number is in σ, a count or a share; any other unit is stated.
    """

    # Log checks: faults of the recording, which are counted and not fitted.

    # rows; fewer rows that repeat all air data may be chance in a quiet log
    repeats_fewest: int = 5
    # σ; independent channels repeat together by chance at a known rate
    repeats_beyond_chance: float = 6.0
    # share of runs of equal length; lost samples do not come at equal distances
    repeats_regular: float = 0.7
    quantization_noise: float = 1.5  # noise deviations; a finer step vanishes in the noise
    quantization_smallest: float = 0.5  # Pa; a finer step is no fault, however quiet the sensor
    clock_odd_step: float = 0.2  # of the median time step; time stamps are rounded by less
    clock_odd_share: float = 0.01  # of the time steps; more of them mean another clock
    counted_score: float = 99.0  # σ; stands for certainty, because a count has no noise

    # Null flights: the scores that an effect has to exceed.
    null_flights_fewest: int = 4  # flights; the spread of fewer says nothing
    # share of flights whose largest score exceeds the threshold by chance
    false_alarms: float = 0.01
    noise_without_null_flights: float = 1.5  # times the noise that the log itself gives
    # logarithm; it reached 27 on 16 flights without an effect in gusts
    gap_without_null_flights: float = 30.0
    # logarithm, without vanes, with a model: 26 on one of 20 flights in gusts, at most 17 on the
    # others. It enters no null flight, so that no table of them depends on it.
    gap_of_path: float = field(default=20.0, repr=False)
    # times the squared shortness; 47 pieces in gusts had 0.75 of it at most
    gap_of_short_log: float = 45.0
    # logarithm; what the model leaves on parts left out is their floor
    gap_of_maneuvers: float = 10.0
    # σ of what gusts imitate of a signature: 1 to 10 on null flights
    fluctuation_unknown: float = 4.0
    # σ of what gusts imitate of a vane's effect: it does not count at all
    vanes_unknown: float = 1000.0
    # of a log, for each fitted cell and each instant of the noise's memory
    instants_a_size: float = 15.0
    # σ; eight flights can show less spread than the noise itself has
    score_deviation_lowest: float = 1.0

    # Explanations: single fits, and the sizes that are told.
    # fall of the SS a further size must bring: ln n for some 400 free instants
    free_size_penalty: float = 6.0
    size_error: float = 0.05  # 1σ of the method as a share of a size: lags come out 3 to 5 % long
    # σ from which an effect on the sensors bends the signatures of the others
    undone_from: float = 8.0

    # The regression: what a hypothesis costs, and when it is taken.
    prior_of_none: float = 0.5  # that no further gap is left; 0.3 to 0.7
    prior_of_unknown: float = 0.05  # that a gap has no cause in the table; 0.02 to 0.2
    prior_of_time: float = 0.2  # that a cause acts for a part of the flight only
    prior_of_rest: float = 0.15  # that something of unknown form is left beside a cause
    # times typical: the scales of a size's prior, each a quarter of the next
    size_scales: tuple[float, ...] = (0.0625, 0.25, 1.0, 4.0)
    rest_sizes: tuple[float, ...] = (4.0, 12.0, 36.0, 108.0, 324.0)  # σ of a smooth discrepancy
    rested: int = 8  # best hypotheses with a rest beside them, and with signatures at their sizes
    open_share: float = 0.25  # of a typical size: what the form of a typical cause leaves open
    search_penalty: float = 2.0  # logarithm of the trials that a searched shape has
    # τ, error of a signature in an unknown direction, as a share; fitted, 0.02 to 0.08
    table_error: float = 0.04
    gap_bayes_factor: float = 2.3  # ln 10: strong evidence (Jeffreys 1961)
    # of a gain that parts left out have too: wrong names 0.1 to 0.5, right ones 1 to 1.3
    held_out_least: float = 0.5
    likely: float = 0.5  # probability from which a gap has no cause in the table
    gaps_most: int = 8  # gaps of one answer, so that the search ends
    set_most: int = 3  # hypotheses of one moment or force in a set; a fourth has nothing to add to
    set_near: float = 3.0  # logarithm: sets less probable by more than e³ are no rivals
    weighings_most: int = 2  # times each gap is weighed again given the others
    linearized_most: int = 5  # times the signatures are computed at the sizes that were found

    # The gate and the map: limits of a name, and what is told of a probability. Fitted to sets 7 to
    # 10 of the blind test and shown on later ones (docs/reconcile.md).
    named_from: float = 0.9  # probability of a cause, as it is told
    named_left: float = 0.07  # share of the gap left, below which a cause is named
    part_named_from: float = 0.9  # probability of a part, given a gap
    told_left: float = 0.1  # share of the gap left, below which a part is named
    told_closed: float = 0.91  # of a probability, where the gap is closed and nothing objects
    told_open: float = 0.33  # of a probability, elsewhere
    set_holds: float = 0.95  # of what the table explains of a gap, in the set that is told

    # What speaks against a name.

    # of a log, also one held out, below which an effect only looks like its cause
    closure_lowest: float = 0.85
    form_error: float = 0.08  # 1σ of the form of an effect in another log, as a share of it
    # times the mean that uncertain sizes leave: one size that is off by 3σ
    left_by_chance: float = 9.0
    # σ between flights, or between parts of one; false in one set of 3,000
    contradicted_from: float = 4.0
    free_told_from: float = 3.0  # σ of its prior, from which an unknown of the log is told

    # The floor of null flights.

    # root mean square of a score on eight null flights: by chance in one of 10,000
    left_over_from: float = 2.0
    # of what null flights say of a size, below which a log does not tell it
    lasting_share: float = 0.01
    # sizes that null flights may still seem to have, so that the search ends
    left_over_most: int = 12
    # sizes of vane effects on null flights of this card, for one of another day
    null_size_margin: float = 2.0
    # surplus of squared scores without null flights: noise that the log itself gives
    wander_unknown: float = 1.0

    # What remains: a gap that no effect of the table explains.
    # σ; one log in 200 by Student's t of eight flights, over some 20 channels
    remaining_wander: float = 6.4
    # of a logarithm: 0.1 to 0.5 from day to day, 14 null flights of two cards
    wander_deviation_lowest: float = 0.3
    # instants, 20 s, with a noise of their own: a throttle's counts more at half power
    wander_nearby: int = 40
    # of the noise of all: a channel that rests for a while has none of its own
    wander_nearby_lowest: float = 0.3
    remaining_line: float = 6.4  # σ; the same count for the strongest spectral line of each channel
    # of the explained SS, which an imperfect signature leaves in a channel
    remaining_share: float = 0.1
    # of the explained SS; an explanation of less than twice the rest names nothing
    outweighing_share: float = 0.5
    # times the noise nearby: an instant farther off counts as much, and no more
    wander_spike: float = 6.0
    # of the channel's surplus before; less is the form error of the named effect
    wander_share: float = 0.5
    line_periods: int = 3  # periods in the log; slower errors are drifts, which the cells show
    # of a log power: the largest of 300 exponential numbers (Gumbel 1958)
    line_deviation_lowest: float = 0.22
    # m/s, deviation below which the air is calm and airspeed is judged by its wander
    calm_gusts: float = 0.1
    gust_level: float = 4.5  # σ of the turbulence level among eight null flights
    # of a logarithm; eight flights do not determine a spread below 2 %
    gust_deviation_lowest: float = 0.02
    noise_noted: float = 1.3  # times the noise of null flights, from which the verdict has a note
    noise_above_null: float = 4.0  # times the noise of null flights; more is a gap, not noise

    # Closure: how much of the gap counts as explainable.
    # fall of the SS (4σ) from which a cell without physics is part of the gap
    gap_cell: float = 16.0
    gap_cells_most: int = 20  # such cells, so that the search ends


THRESHOLDS = Thresholds()
