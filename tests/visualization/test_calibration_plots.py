"""Pictures of calibration: legible in greyscale, marks where they belong, and a refusal of what is no share."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ichain_drake.errors import InputError
from ichain_drake.visualization import plot_coverage, plot_reliability


def grey(file: Path) -> np.ndarray:
    return np.asarray(Image.open(file).convert("L")).astype(int)


def test_what_is_too_sure_leaves_the_diagonal(tmp_path: Path) -> None:
    honest, sure = [(0.1, 0.1, 500), (0.9, 0.9, 500)], [(0.1, 0.4, 500), (0.9, 0.6, 500)]
    middles = []
    for name, bins in (("honest", honest), ("sure", sure)):
        plot_reliability(tmp_path / f"{name}.png", {"a->b": bins})
        rows, columns = np.nonzero(grey(tmp_path / f"{name}.png") < 110)
        middles.append(rows[columns < np.median(columns)].mean())
    assert middles[1] < middles[0] - 5, "its left mark stands higher"
    plot_reliability(tmp_path / "many.png", {f"a->{k}": honest for k in range(7)})
    assert grey(tmp_path / "many.png").shape[0] > 1.5 * grey(tmp_path / "honest.png").shape[0]


def test_every_variable_has_a_row_and_every_way_a_mark(tmp_path: Path) -> None:
    shares = {f"cup.{k}": {"spread": 0.75 + 0.03 * k, "scaled": 0.9} for k in range(6)}
    plot_coverage(tmp_path / "c.png", shares, level=0.9)
    plot_coverage(tmp_path / "one.png", {n: {"scaled": 0.9} for n in shares}, level=0.9)
    assert grey(tmp_path / "c.png").shape[0] > 200
    assert (grey(tmp_path / "c.png") < 60).sum() > (grey(tmp_path / "one.png") < 60).sum()


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "p.png"
    for bins in ({}, {"a->b": []}):
        with pytest.raises(InputError, match="no bin with any row; nothing to draw"):
            plot_reliability(file, bins)
    with pytest.raises(InputError, match=r"a->b: probabilities and shares lie in \[0, 1\]"):
        plot_reliability(file, {"a->b": [(0.5, 1.5, 3)]})
    for shares in ({}, {"a": {}}, {"a": {"spread": 0.9}, "b": {"scaled": 0.9}}):
        with pytest.raises(InputError, match="every variable needs a share of the same ways"):
            plot_coverage(file, shares, level=0.9)
    with pytest.raises(InputError, match="a picture ends in .png"):
        plot_coverage(tmp_path / "p.jpg", {"a": {"spread": 0.9}}, level=0.9)
    assert list(tmp_path.iterdir()) == []
