"""The guards find what they are for: a changed number, a lost body, a name that leads nowhere."""

import pytest

from pitotlab.guards.bodies import changed_pairs, compare, read_renames
from pitotlab.guards.differences import differences
from pitotlab.guards.names import missing_names

OLD = {
    "pitotbench.lag": '''"""Lag."""
from pitotbench import air
from pitotbench.names import table as _names

_EDGE = 3.0

def late(values, lag_s=0.4):
    """Values late by a lag."""
    from pitotbench.names import table
    return air.density(values) * lag_s + _EDGE + _names

class Line:
    size: float = 1.0

    def length(self):
        return self.size
''',
    "pitotbench.air": "def density(values):\n    return values\n",
    "pitotbench.names": "table = 1\nwhere = 'pitotbench.lag'\n",
}
# The same code in one module: the docstring is another, the import is gone, and the string names
# the new place.
MOVED = {
    "pitotbench.pneumatic": '''
table = 1
where = 'pitotbench.pneumatic'

def density(values):
    return values

_EDGE = 3.0

def late(values, lag_s=0.4):
    return density(values) * lag_s + _EDGE + table

class Line:
    """A line."""

    size: float = 1.0

    def length(self):
        return self.size
'''
}


def edited(old, new):
    assert old in MOVED["pitotbench.pneumatic"]
    return {"pitotbench.pneumatic": MOVED["pitotbench.pneumatic"].replace(old, new)}


def found(new, renames=None):
    return [
        (name, bool(was), bool(now))
        for name, _, was, now in changed_pairs(compare(OLD, new, renames or {}))
    ]


def test_a_move_changes_no_body():
    assert found(MOVED) == []


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        ("lag_s=0.4", "lag_s=0.5", "late"),
        ("_EDGE = 3.0", "_EDGE = 3.1", "_EDGE"),
        ("size: float = 1.0", "size: float = 1.5", "Line"),
        ("return self.size", "return -self.size", "Line.length"),
        ("+ _EDGE", "- _EDGE", "late"),
    ],
)
def test_a_changed_constant_or_sign_is_found(old, new, name):
    assert found(edited(old, new)) == [(name, True, True)]


def test_a_lost_body_and_a_lost_twin_are_found():
    assert found(edited("def density(values):\n    return values\n", "")) == [
        ("density", True, False)
    ]
    twice = {**OLD, "pitotbench.twin": OLD["pitotbench.air"]}
    assert [body.name for body in compare(twice, MOVED, {}).fewer] == ["density"]


def test_a_rename_counts_unless_it_is_listed(tmp_path):
    renamed = {"pitotbench.pneumatic": MOVED["pitotbench.pneumatic"].replace("_EDGE", "LAG_EDGE")}
    assert found(renamed) == [
        ("LAG_EDGE", False, True),
        ("_EDGE", True, False),
        ("late", True, True),
    ]
    for scope in ("*", "pitotbench.lag"):
        (tmp_path / "renames.toml").write_text(f'["{scope}"]\n_EDGE = "LAG_EDGE"\n')
        assert found(renamed, read_renames(tmp_path / "renames.toml")) == []
    assert found(renamed, {"pitotbench.air": {"_EDGE": "LAG_EDGE"}}) != []


def test_a_renamed_function_is_followed_where_it_is_imported():
    imported = (
        OLD["pitotbench.lag"]
        .replace("import air", "import air, again")
        .replace("air.density", "again")
    )
    old = {
        **OLD,
        "pitotbench.lag": imported,
        "pitotbench": "from pitotbench.air import density as again",
    }
    new = {"pitotbench.pneumatic": MOVED["pitotbench.pneumatic"].replace("density", "air_density")}
    assert not compare(old, new, {"pitotbench.air": {"density": "air_density"}}).gone
    assert compare(old, new, {"pitotbench.names": {"density": "air_density"}}).gone


def test_numbers_are_compared_bit_by_bit_and_told_in_their_two_sigma():
    curve = {"curve": [{"correction_kt": 1.0, "two_sigma_kt": 0.5}], "unknown": float("nan")}
    assert list(differences(curve, curve)) == []
    other = {"curve": [{"correction_kt": 1.2, "two_sigma_kt": 0.5}], "unknown": float("nan")}
    (line,) = differences(curve, other)
    assert line.startswith("curve[0].correction_kt: 1.0 → 1.2, by +0.2, 0.4 of its 2σ: A DEFECT")
    (line,) = differences({"a": 1.0}, {"a": 1})
    assert line.startswith("a: 1.0 → 1")


def test_texts_are_told_line_by_line_and_missing_keys_by_side():
    assert list(differences({"a": "x\ny\n"}, {"a": "x\nz\n"})) == [
        "a: 2 lines differ",
        "    -y",
        "    +z",
    ]
    assert list(differences({"a": None}, {"b": 1})) == ["a: only before: None", "b: only today: 1"]


def test_a_name_that_leads_nowhere_is_found(tmp_path):
    package = tmp_path / "src" / "pitotbench"
    (package / "old").mkdir(parents=True)
    (package / "old" / "lag.py").write_text("late = 1\n")
    (package / "page.py").write_text('HERE = "pitotbench.old.lag.late", "old.lag"\n')
    assert list(missing_names(tmp_path)) == []
    today = tmp_path / "today"
    (today / "src" / "pitotbench").mkdir(parents=True)
    (today / "src" / "pitotbench" / "page.py").write_text((package / "page.py").read_text())
    (today / "Makefile").write_text("run:\n\tpytest tests/gone src/pitotbench/page.py\n")
    assert list(missing_names(today, tmp_path)) == [
        "src/pitotbench/page.py:1: pitotbench.old.lag.late",
        "src/pitotbench/page.py:1: 'old.lag' was a module or a file",
        "Makefile:2: tests/gone",
    ]
