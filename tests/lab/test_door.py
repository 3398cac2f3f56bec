"""The table of foreign files calls right what holds the truth, and nothing else."""

from tests.shared_data import shared_case

from pitotlab.door import CASES, Outcome, correction, factor, parameters, refused, run


def answer(*points, **more):
    """An answer with points of KIAS, correction and bound [kt]."""
    keys = ("indicated_airspeed_kt", "correction_kt", "two_sigma_kt")
    curve = [dict(zip(keys, point, strict=True)) for point in points]
    return Outcome(0, ({"curve": curve, **more},), "")


def test_a_curve_is_right_where_each_of_its_ends_holds_the_truth():
    wind = {"north_kt": 0.0, "east_kt": 10.0}  # from the west
    found = answer((60.0, 1.8, 0.5), (80.0, 2.1, 0.5), (100.0, 2.4, 0.5), wind=wind)
    assert correction(2.0, (10.0, 270.0))(found)
    assert not correction(2.0, (10.0, 90.0))(found)
    assert not correction(2.0, bound=0.4)(found)
    assert not correction(1.5)(found)
    assert not correction(2.0)(answer((60.0, 2.0, 0.5), usable=False))
    assert factor(1.03)(answer((60.0, 1.8, 0.5), (100.0, 3.0, 0.5)))
    assert not factor(1.03)(answer((60.0, 1.8, 0.5), (100.0, 1.8, 0.5)))


def test_a_refusal_is_right_for_its_words_and_an_answer_never():
    said = Outcome(2, (), "this recorder logs no airspeed")
    assert refused("no airspeed")(said)
    assert not refused("no GPS")(said)
    assert not refused()(answer((60.0, 0.0, 1.0)))


def test_parameters_are_right_inside_their_bounds():
    found = answer(params=[{"name": "ARSPD_RATIO", "value": 2.1, "two_sigma": 0.2}])
    assert parameters(ARSPD_RATIO=2.0)(found)
    assert not parameters(ARSPD_RATIO=1.8)(found)
    assert not parameters(ARSPD_OFFSET=0.0)(found)


def test_a_file_is_tried_as_it_is_typed():
    name = "18-headings-written-as-tracks.csv"
    case = next(each for each in CASES if each.file == name)
    outcome, _ = run(case.command, shared_case(name))
    assert case.right(outcome)
