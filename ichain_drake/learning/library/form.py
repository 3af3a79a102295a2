"""The form that a JSON document must have: a small schema that names the field which hasn't it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from ichain_drake.errors import InputError

_EXACT = 2**53  # whole numbers below it are the same as floats


class Nullable:
    """A field that has a form, or is null.

    Args:
        form: see `find_misfit`.
    """

    def __init__(self, form: Any) -> None:
        self.form = form


class Free:
    """Whatever stands here is checked elsewhere."""


class Keyed:
    """An object whose names are data.

    Args:
        name: form of its names.
        item: form of its values.
    """

    def __init__(self, name: Any, item: Any) -> None:
        self.name = name
        self.item = item


def refusal(where: str, path: str, what: str) -> InputError:
    """The error that names a field of a file."""
    return InputError(f"{where}: {path or 'contents'}: {what}; the file is damaged or was edited: save the link anew")


def _is_number(value: Any, *, whole: bool) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < _EXACT if isinstance(value, int) else not whole and math.isfinite(value)


def is_form(value: Any, form: Any) -> bool:
    """Whether a single value fits: `int`, `float` (finite), `str`, a choice of texts, a pattern, or a test of texts."""
    if form in (int, float):
        return _is_number(value, whole=form is int)
    if not isinstance(value, str):
        return False
    if isinstance(form, tuple):
        return value in form
    if isinstance(form, re.Pattern):
        return form.fullmatch(value) is not None
    test: Callable[[str], bool] | None = None if form is str else form
    return test is None or test(value)


def find_misfit(value: Any, form: Any, path: str = "") -> tuple[str, str] | None:
    """The first place where a document hasn't its form.

    Args:
        value: the document as `json.loads` gives it, or a part of it.
        form: for a single value see `is_form`; `[form]` for a list of such, `{name: form}` for exactly these fields,
            `Nullable`, `Keyed`, `Free`.
        path: of the part.

    Returns:
        The field and what is wrong with it, or None where all is well.
    """
    if isinstance(form, Free):
        return None
    if isinstance(form, Nullable):
        return None if value is None else find_misfit(value, form.form, path)
    if isinstance(form, dict | Keyed):
        return _misfit_of_fields(value, form, path)
    if isinstance(form, list):
        if not isinstance(value, list):
            return path, f"a list is needed, found {value!r:.60}"
        found = (find_misfit(item, form[0], f"{path}[{i}]") for i, item in enumerate(value))
        return next((misfit for misfit in found if misfit), None)
    return None if is_form(value, form) else (path, f"{value!r:.60} can't stand here")


def _misfit_of_fields(value: Any, form: dict[str, Any] | Keyed, path: str) -> tuple[str, str] | None:
    if not isinstance(value, dict):
        return path, f"named fields are needed, found {value!r:.60}"
    for name in value if isinstance(form, Keyed) else (*form, *value):
        inner = f"{path}.{name:.60}".lstrip(".")
        if isinstance(form, Keyed):
            if not is_form(name, form.name):
                return path, f"{name!r:.60} is no name that may stand here"
        elif name not in value or name not in form:
            return inner, "missing" if name in form else "unknown field"
        misfit = find_misfit(value[name], form.item if isinstance(form, Keyed) else form[name], inner)
        if misfit:
            return misfit
    return None
