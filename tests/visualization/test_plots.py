"""Pictures are written, legible in greyscale, and refuse what they can't draw."""

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from ichain_drake.errors import InputError
from ichain_drake.visualization import Lane, Strip, plot_learning_curve, plot_paths, plot_success_curve, plot_timeline

T = np.linspace(0, 2 * np.pi, 200)
PATHS = {
    "eight": np.column_stack([400 + 230 * np.sin(T), 300 + 150 * np.sin(2 * T)]),
    "line": np.array([[0, 0], [9, 9]]),
}
TABLE = pd.DataFrame(
    [{"samples": n, "error": e, "method": m} for m in ("chain", "flat") for n in (10, 20) for e in (1.0, 2.0, 4.0)]
)


def test_commanded_and_executed_differ_in_greyscale(tmp_path):
    file = tmp_path / "paths.png"
    plot_paths(file, PATHS, {k: v + 15 for k, v in PATHS.items()}, errors={"eight": 21.2})
    grey = np.asarray(Image.open(file).convert("L")).astype(int)
    commanded, executed = (np.abs(grey - 184) < 6).sum(), (np.abs(grey - 87) < 12).sum()
    assert commanded > 2000 and executed > 500


def test_y_direction_of_the_game(tmp_path):
    """A path low in the game (large y) lies low in the picture if y points down, and high if not."""
    path = {"hook": np.column_stack([np.linspace(0, 100, 50), np.where(np.linspace(0, 1, 50) < 0.9, 100.0, 0.0)])}
    rows = {}
    for y_down in (True, False):
        plot_paths(tmp_path / "p.png", path, path, y_down=y_down)
        image = np.asarray(Image.open(tmp_path / "p.png").convert("RGB")).astype(int)
        red = (image[..., 0] - image[..., 2] > 120)[: int(image.shape[0] * 0.85)]  # without the legend
        rows[y_down] = np.mean(np.nonzero(red)[0])
    assert rows[True] > rows[False] + 40


def test_learning_curve_is_written(tmp_path):
    plot_learning_curve(tmp_path / "curve.png", TABLE, unit="px", logarithmic=True)
    plot_learning_curve(tmp_path / "one.png", TABLE.drop(columns="method"))
    for name in ("curve.png", "one.png"):
        assert np.asarray(Image.open(tmp_path / name).convert("L")).std() > 5


RUNS = pd.DataFrame(
    [{"pieces": n, "success": n > 6 or k > 0, "control_steps": 400 + 10 * k} for n in (6, 8, 10) for k in range(4)]
)


def grey(file):
    return np.asarray(Image.open(file).convert("L")).astype(int)


def test_success_over_the_number_of_pieces_is_written(tmp_path):
    plot_success_curve(tmp_path / "pieces.png", RUNS)
    plot_success_curve(tmp_path / "none.png", RUNS.assign(success=False))  # then no run's length is drawn
    assert grey(tmp_path / "pieces.png").std() > 5
    assert (grey(tmp_path / "pieces.png") < 60).sum() > (grey(tmp_path / "none.png") < 60).sum()


def test_truth_and_classifier_differ_in_greyscale_and_bars_are_where_they_belong(tmp_path):
    lanes = {"a->b": [Lane("truth", "solid", [(0.0, 5.0)]), Lane("classifier", "grey", [(5.0, 5.0)])], "b->c": []}
    plot_timeline(tmp_path / "t.png", lanes, 10.0)
    image = grey(tmp_path / "t.png")
    rows = {shade: np.argwhere(np.abs(image - shade) < 4) for shade in (38, 166)}
    bars = {s: p[np.bincount(p[:, 0], minlength=len(image))[p[:, 0]] > 200] for s, p in rows.items()}  # no text
    (truth_end, truth_bottom), (classifier_start, classifier_top) = (
        (np.percentile(bars[38][:, 1], 99), bars[38][:, 0].max()),
        (np.percentile(bars[166][:, 1], 1), bars[166][:, 0].min()),
    )
    assert truth_end < classifier_start  # the one ends where the other begins
    assert truth_bottom < classifier_top  # on lines of their own


def test_wanted_band_of_a_strip_is_shaded(tmp_path):
    t = np.linspace(0, 10, 50)
    lanes = {"a->b": [Lane("controller activates", "rising", [(1.0, 2.0)])]}
    images = []
    for k, strip in enumerate((Strip(t / 10, "m", 0.5), Strip(t / 10, "m"))):
        plot_timeline(tmp_path / f"{k}.png", lanes, 10.0, {"level": strip}, t)
        images.append(grey(tmp_path / f"{k}.png"))
    shaded, plain = ((np.abs(image - 222) < 3).sum() for image in images)
    assert shaded > plain + 5000


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(InputError, match="no interaction to draw"):
        plot_timeline(tmp_path / "t.png", {}, 1.0)
    with pytest.raises(InputError, match=r"strip 'x' has shape \(3,\), its times \(2,\)"):
        plot_timeline(tmp_path / "t.png", {"a->b": []}, 1.0, {"x": Strip(np.zeros(3))}, np.zeros(2))
    with pytest.raises(InputError, match="no column 'control_steps'; it has pieces, success"):
        plot_success_curve(tmp_path / "c.png", RUNS[["pieces", "success"]])
    with pytest.raises(InputError, match="the table has no rows"):
        plot_success_curve(tmp_path / "c.png", RUNS.iloc[:0])
    with pytest.raises(InputError, match="the same paths needed in both; commanded eight, line, executed eight"):
        plot_paths(tmp_path / "p.png", PATHS, {"eight": PATHS["eight"]})
    with pytest.raises(InputError, match=r"executed path eight: shape \(n, 2\) with n >= 1 needed, \(2, 200\) given"):
        plot_paths(tmp_path / "p.png", {"eight": PATHS["eight"]}, {"eight": PATHS["eight"].T})
    with pytest.raises(InputError, match="a picture ends in .png"):
        plot_paths(tmp_path / "p.jpg", PATHS, PATHS)
    with pytest.raises(InputError, match="the table has no column 'loss'; it has samples, error, method"):
        plot_learning_curve(tmp_path / "c.png", TABLE, y="loss")
    with pytest.raises(InputError, match="the table has no rows"):
        plot_learning_curve(tmp_path / "c.png", TABLE.iloc[:0])
    with pytest.raises(InputError, match=r"p.png: can't write .*No such file"):
        plot_paths(tmp_path / "none" / "p.png", PATHS, PATHS)
    assert list(tmp_path.iterdir()) == []
