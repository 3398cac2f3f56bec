"""A wrong name is answered with the known ones and the nearest."""

import pytest

from pitotbench.catalog import Catalog, UnknownNameError, explain

FRUIT = Catalog("fruit", {"apple": 1, "banana": 2})


def test_a_near_miss_is_answered_and_a_far_one_gets_no_guess():
    assert list(FRUIT) == ["apple", "banana"]
    assert (FRUIT["banana"], len(FRUIT), "apple" in FRUIT, "pear" in FRUIT) == (2, 2, True, False)
    says = r"unknown fruit 'bananna'. Did you mean 'banana'\? Known: apple, banana"
    for look_up in (FRUIT.__getitem__, FRUIT.get):
        with pytest.raises(UnknownNameError, match=says):
            look_up("bananna")
    assert "Did you mean" not in explain("fruit", "xyz", list(FRUIT))


def test_a_catalog_cannot_be_changed():
    with pytest.raises(TypeError):
        FRUIT["cherry"] = 3
    source = {"a": 1}
    table = Catalog("letter", source)
    source["b"] = 2
    assert list(table) == ["a"]
