"""A wrong name is answered with the known ones and the nearest."""

import pytest

from pitotbench.catalog import Catalog, UnknownNameError, explain

FRUIT = Catalog("fruit", {"apple": 1, "banana": 2})


def test_known_names_in_order():
    assert list(FRUIT) == ["apple", "banana"]
    assert (FRUIT["banana"], len(FRUIT), "apple" in FRUIT, "pear" in FRUIT) == (2, 2, True, False)


def test_a_near_miss_is_answered():
    with pytest.raises(
        UnknownNameError, match=r"unknown fruit 'bananna'. Did you mean 'banana'\? Known: apple, banana"
    ):
        FRUIT["bananna"]


def test_a_far_miss_gets_no_guess():
    assert "Did you mean" not in explain("fruit", "xyz", list(FRUIT))


def test_get_with_default_does_not_raise():
    assert "kiwi" not in FRUIT
    with pytest.raises(UnknownNameError):
        FRUIT.get("kiwi")


def test_a_catalog_cannot_be_changed():
    with pytest.raises(TypeError):
        FRUIT["cherry"] = 3
    source = {"a": 1}
    table = Catalog("letter", source)
    source["b"] = 2
    assert list(table) == ["a"]
