"""The form of a document: each value that does not fit is named with its place, and what fits is let be."""

import re
from typing import Any

import pytest

from ichain_drake.learning.library.form import Free, Keyed, Nullable, find_misfit, is_form, refusal


@pytest.mark.parametrize(
    ("value", "form", "fits"),
    [
        (3, int, True), (-3, int, True), (2**53 - 1, int, True), (2**53, int, False), (-(2**53), int, False),
        (3.0, int, False), (True, int, False), ("3", int, False), (None, int, False),
        (3, float, True), (3.5, float, True), (float("inf"), float, False), (float("nan"), float, False),
        (False, float, False), (2**53, float, False), ("3.5", float, False),
        ("a", str, True), (1, str, False), (None, str, False), ("", str, True),
        ("a", ("a", "b"), True), ("c", ("a", "b"), False), (1, ("a", 1), False),
        ("ab", re.compile("[ab]+"), True), ("abc", re.compile("[ab]+"), False),
        ("ab", str.isalpha, True), ("a1", str.isalpha, False), (7, str.isalpha, False),
    ],
)  # fmt: skip
def test_a_single_value_is_of_its_form_or_not(value: Any, form: Any, *, fits: bool) -> None:
    assert is_form(value, form) is fits


FORM = {
    "name": str,
    "rows": [{"size": float, "note": Nullable(str)}],
    "by": Keyed(re.compile("[a-z]"), int),
    "other": Free(),
}
WHOLE = {
    "name": "x",
    "rows": [{"size": 1.5, "note": None}, {"size": 2, "note": "y"}],
    "by": {"a": 1, "b": 2},
    "other": [],
}


def changed(**more: Any) -> dict[str, Any]:
    return {**WHOLE, **more}


def test_what_fits_has_no_misfit() -> None:
    assert find_misfit(WHOLE, FORM) is None
    assert find_misfit(changed(rows=[], by={}, other={"any": float("nan")}), FORM) is None


@pytest.mark.parametrize(
    ("document", "place", "what"),
    [
        ([], "", "named fields are needed, found []"),
        ({k: v for k, v in WHOLE.items() if k != "by"}, "by", "missing"),
        (changed(more=1), "more", "unknown field"),
        (changed(name=3), "name", "3 can't stand here"),
        (changed(rows={"a": 1}), "rows", "a list is needed, found {'a': 1}"),
        (changed(rows=[WHOLE["rows"][0], {"size": "big", "note": None}]), "rows[1].size", "'big' can't stand here"),
        (changed(rows=[{"size": 1.0, "note": 4}]), "rows[0].note", "4 can't stand here"),
        (changed(rows=[{"size": 1.0}]), "rows[0].note", "missing"),
        (changed(by={"a": 1, "B": 2}), "by", "'B' is no name that may stand here"),
        (changed(by={"a": 1.5}), "by.a", "1.5 can't stand here"),
        (changed(by=None), "by", "named fields are needed, found None"),
    ],
)
def test_the_first_misfit_is_named_with_its_place(document: Any, place: str, what: str) -> None:
    assert find_misfit(document, FORM) == (place, what)
    assert f"file.json: {place or 'contents'}: {what}; the file is damaged" in str(refusal("file.json", place, what))


def test_what_is_quoted_is_kept_short() -> None:
    found = find_misfit(changed(name=["x" * 500]), FORM)
    assert found is not None
    assert len(found[1]) < 90
