"""What the playback shows beside the scene: graph, strips, flags; and how large a long one becomes."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser
from ichain_drake.visualization import RecordedEpisode, Recording, Strip, load_recording, save_recording, write_playback
from ichain_drake.visualization.graph_layout import layout_graph


def edges(*names):
    return tuple(Interaction.parse(name) for name in names)


GRAPHS = {
    "dispenser": edges("hand->cup", "hand->a", "hand->b", "cup->tank", "a->tank", "b->tank", "tank->cup"),
    "chain": edges("hand->stick", "stick->car"),
    "oven": edges("hand->door", "hand->button", "hand->knob", "hand->food", "knob->food", "door->food", "button->food"),
    "skipping": edges("hand->a", "a->b", "b->c", "hand->c", "c->a"),
}


def names_of(interactions):
    return list(dict.fromkeys(itertools.chain(*((e.parent, e.child) for e in interactions))))


@pytest.mark.parametrize("graph", GRAPHS)
def test_no_box_overlaps_and_no_arrow_runs_through_a_foreign_box(graph):
    layout = layout_graph(names_of(GRAPHS[graph]), GRAPHS[graph])
    for a, b in itertools.combinations(layout.boxes.values(), 2):
        assert (np.abs(a[:2] - b[:2]) >= (a[2:] + b[2:]) / 2).any()
    for box in layout.boxes.values():
        assert (box[:2] - box[2:] / 2 >= 0).all()
        assert (box[:2] + box[2:] / 2 <= [layout.width, layout.height]).all()
    for edge in GRAPHS[graph]:
        points = layout.points(edge)
        assert (points >= 0).all() and (points <= [layout.width, layout.height]).all()
        for name, box in layout.boxes.items():
            inside = (np.abs(points - box[:2]) < box[2:] / 2 - 1e-6).all(axis=1)
            assert not inside.any(), (edge, name)
        for end, box in ((points[0], layout.boxes[edge.parent]), (points[-1], layout.boxes[edge.child])):
            assert (np.abs(end - box[:2]) - box[2:] / 2).max() < 2.5  # touches its own boxes


def test_the_two_ways_between_two_objects_are_apart():
    layout = layout_graph(names_of(GRAPHS["dispenser"]), GRAPHS["dispenser"])
    there, back = (layout.points(e)[12] for e in edges("cup->tank", "tank->cup"))
    assert np.linalg.norm(there - back) > 8


def test_page_has_switches_and_strips_as_logged(recording, records):
    log = json.loads(records[0])
    (edge,) = log["graph"]["edges"]
    assert (edge["name"], edge["switched"][0]) == ("lamp->car", [30, 60, 90, 120, 150, 180])
    assert [box["name"] for box in log["graph"]["boxes"]] == ["lamp", "car"]
    level, free = log["strips"]
    assert (level["label"], level["values"][0]["lower"], level["values"][0]["upper"]) == ("lamp level", 0.5, None)
    want = recording.episodes[1].strips["lamp level"].values
    assert level["values"][1]["values"] == pytest.approx(want, abs=1e-3)
    assert (free["values"][0]["wanted"], free["values"][0]["values"][:2]) == (False, [None, None])


def test_hidden_variables_are_not_listed(drawings, inflated, tmp_path, recording):
    hidden = dataclasses.replace(recording.spaces["lamp"].variables[0], hidden=True)
    space = dataclasses.replace(recording.spaces["lamp"], variables=(hidden, recording.spaces["lamp"].variables[1]))
    write_playback(dataclasses.replace(recording, spaces={**recording.spaces, "lamp": space}), {}, tmp_path / "p.html")
    log = json.loads(inflated(tmp_path / "p.html")[0])
    assert [v["label"] for v in log["objects"][0]["variables"]] == ["on"]


def test_saved_recording_gives_flags_and_strips_back(recording, tmp_path):
    save_recording(recording, tmp_path / "run.npz")
    loaded = load_recording(tmp_path / "run.npz")
    assert loaded.interactions == recording.interactions
    for a, b in zip(loaded.episodes, recording.episodes, strict=True):
        np.testing.assert_array_equal(a.active["lamp->car"], b.active["lamp->car"])
        for label, strip in b.strips.items():
            np.testing.assert_array_equal(a.strips[label].values, strip.values)
            got = a.strips[label]
            assert (got.unit, got.lower, got.upper) == (strip.unit, strip.lower, strip.upper)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"active": {"car->lamp": np.zeros(121, dtype=bool)}},
            "flags of 'car->lamp'; the recording's interactions are",
        ),
        ({"active": {"lamp->car": np.zeros(3, dtype=bool)}}, r"flags of lamp->car need shape \(121,\), shape \(3,\)"),
        ({"strips": {"x": Strip(np.zeros(2))}}, r"strip 'x' needs shape \(121,\), shape \(2,\) given"),
    ],
)
def test_misfitting_flags_and_strips_are_refused(recording, change, message):
    bad = dataclasses.replace(recording.episodes[1], **change)
    with pytest.raises(InputError, match=message):
        dataclasses.replace(recording, episodes=(bad,))


def test_interactions_of_other_objects_are_refused(recording):
    with pytest.raises(InputError, match="interaction hand->car: the recording's objects are lamp, car"):
        dataclasses.replace(recording, interactions=edges("hand->car"))


def test_an_hour_of_the_full_scene_is_at_most_30_mb(tmp_path):
    """By five minutes and a second: an arm that goes elsewhere at every tick, and everything else in motion."""
    scenario = WaterDispenser((), "contact")
    plant = scenario.drawn_plant()
    rng, n = np.random.default_rng(0), 300 * 30 + 1
    t = np.arange(n) / 30
    start = plant.plant.GetPositions(plant.plant.CreateDefaultContext())
    targets = start[:7] + np.cumsum(rng.normal(0, 0.04, (n // 10 + 2, 7)), axis=0)
    share = np.minimum((np.arange(n) % 10) / 4, 1.0)[:, None]  # as the hand moves: a part of each tick, then it holds
    q = np.tile(start, (n, 1))
    q[:, :7] = targets[np.arange(n) // 10] + share * np.diff(targets, axis=0)[np.arange(n) // 10]
    states = {name: np.zeros((n, len(space))) for name, space in scenario.graph.objects.items()}
    states["cup"][:, :6] = np.column_stack([0.1 * np.sin(t + k) + 0.5 for k in range(6)])
    states["tank"][:, :2] = np.column_stack([0.5 + 0.4 * np.sin(0.1 * t), 0.5 + 0.4 * np.cos(0.07 * t)])
    strips = {f"strip {k}": Strip(0.5 + 0.4 * np.sin(0.3 * t + k)) for k in range(6)}
    flags = {e.name: np.floor(t / (3 + k)) % 2 == 1 for k, e in enumerate(scenario.graph.interactions)}
    episode = RecordedEpisode("long", t, states, q, {}, {}, flags, strips)
    recording = Recording("long", "contact", 0, scenario.graph.objects, (episode,), scenario.graph.interactions)
    write_playback(recording, scenario.drawings(), tmp_path / "long.html", plant=plant)
    whole = (tmp_path / "long.html").stat().st_size
    short = dataclasses.replace(
        episode, times=t[:31], states={name: s[:31] for name, s in states.items()}, plant_positions=q[:31],
        active={name: f[:31] for name, f in flags.items()},
        strips={label: Strip(strip.values[:31]) for label, strip in strips.items()},
    )  # fmt: skip
    write_playback(
        dataclasses.replace(recording, episodes=(short,)), scenario.drawings(), tmp_path / "s.html", plant=plant
    )
    scene = (tmp_path / "s.html").stat().st_size
    assert whole < 8e6
    assert scene + 12 * (whole - scene) < 30e6
