"""Arrays of a library's files: stored plainly, each under one name."""

import io
import zipfile

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning.library.weights import pack_arrays, unpack_arrays

ARRAYS = {"a": np.arange(3.0), "b": np.zeros(400)}


def test_what_was_packed_comes_back() -> None:
    found = unpack_arrays(pack_arrays(ARRAYS), "x.npz")
    assert set(found) == set(ARRAYS)
    for name, values in ARRAYS.items():
        np.testing.assert_array_equal(found[name], values)


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("damage", ["compressed", "twice"])
def test_what_could_unfold_and_what_is_named_twice_is_refused(damage: str) -> None:
    stream = io.BytesIO()
    if damage == "compressed":
        np.savez_compressed(stream, **ARRAYS)  # type: ignore[arg-type]
    else:
        stream.write(pack_arrays(ARRAYS))
        with zipfile.ZipFile(stream, "a") as archive:
            archive.writestr("a.npy", archive.read("a.npy"))
    with pytest.raises(InputError, match="it is compressed or names an array twice"):
        unpack_arrays(stream.getvalue(), "x.npz")
