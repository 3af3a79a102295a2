"""`learn`, `plan`, `run` and `library` with a whole graph on disk, on a graph that is not the library's own."""

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake.control.planning.skills import Skills
from ichain_drake.demonstrations import write_demonstrations
from ichain_drake.learning.library import load_graph
from ichain_drake.systems import SCENARIOS

GOAL = ["0.55 <= lamp.light <= 0.65", "not hand->dimmer"]


def _lamp() -> ModuleType:
    file = Path(__file__).parents[1] / "helpers" / "lamp.py"
    spec = importlib.util.spec_from_file_location("lamp", file)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules.setdefault("lamp", importlib.util.module_from_spec(spec))
    spec.loader.exec_module(module)
    return module


class DrawnLamp(_lamp().LampScenario):  # type: ignore[misc]
    """With settings, a goal of its own, and nothing to draw."""

    def __init__(self, overrides=(), physics="ideal", seed=0):
        super().__init__(overrides, physics, seed)
        self.config = ic.ScenarioConfig()
        self.config.goal = GOAL
        for setting in overrides:
            key, _, value = setting.partition("=")
            section, _, name = key.partition(".")
            setattr(getattr(self.config, section), name, int(value) if value.isdigit() else value)

    def drawings(self):
        return {}

    def drawn_plant(self):
        return None

    def view(self):
        return None


@pytest.fixture(autouse=True)
def lamp(monkeypatch):
    monkeypatch.setitem(SCENARIOS, "lamp", DrawnLamp)


@pytest.fixture(scope="module")
def demos(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("lamp") / "demos"
    with threadpool_limits(limits=1):
        write_demonstrations(list(DrawnLamp().record_demonstrations()), folder)
    return folder


@pytest.fixture(scope="module")
def library(demos, tmp_path_factory) -> Path:
    from ichain_drake.cli.learn_library import learn_library

    folder = tmp_path_factory.mktemp("library") / "of lamps"
    learn_library(DrawnLamp(), demos, folder)
    return folder


def test_learn_writes_a_library_that_can_be_looked_at(ichain, demos, library, tmp_path):
    said = ichain("learn", "lamp", "--demos", demos, "-o", tmp_path / "again", "--set",
                  "learning.estimator=polynomial(degree=1, clip=None)")  # fmt: skip
    assert said.status == 0, said.err
    lines = said.out.splitlines()
    assert [line.split(":")[0] for line in lines] == ["hand->dimmer", "hand->switch", "dimmer->lamp", "switch->lamp"]
    assert "changes x" in lines[0]
    learned = load_graph(tmp_path / "again", "lamp", DrawnLamp.graph)
    used = {e.regression.estimator for edge in learned.edges.values() for e in edge.effects}
    assert used == {"polynomial(degree=1, clip=None)", "as declared"}
    listed = ichain("library", "list", "--library", library)
    assert (listed.status, "graph.lamp" in listed.out, "4 interactions" in listed.out) == (0, True, True)
    shown = ichain("library", "show", "graph.lamp", "--library", library)
    assert shown.status == 0
    assert "lamp: light [1]" in shown.out
    assert "dimmer->lamp" in shown.out
    assert ichain("library", "check", library).out.strip() == f"{library}: good"
    assert ichain("library", "add", library, "--library", tmp_path / "again").status == 0
    weights = tmp_path / "again" / "graph.lamp" / "model.npz"
    weights.write_bytes(weights.read_bytes()[:-20])
    bad = ichain("library", "check", tmp_path / "again")
    assert bad.status == 2
    assert "model.npz: its sha256 is not the manifest's" in bad.out
    assert ichain("plan", "lamp", "--physics", "ideal", "--library", tmp_path / "again").status == 2


def test_a_plan_from_the_library_is_the_one_from_the_demonstrations(ichain, demos, library):
    stored = ichain("plan", "lamp", "--physics", "ideal", "--library", library)
    learned = ichain("plan", "lamp", "--physics", "ideal", "--demos", demos)
    assert (stored.status, stored.out) == (learned.status, learned.out)
    assert stored.status == 0
    assert "learning" in learned.err
    assert "learning" not in stored.err
    assert "recording" not in stored.err


def test_a_run_from_the_library_only_differs_in_its_source(ichain, demos, library, tmp_path):
    reports = []
    for way in (("--library", library), ("--demos", demos)):
        done = ichain("run", "lamp", "--physics", "ideal", *way, "-o", tmp_path / way[0][2:], "--report", "-")
        assert done.status == 0, done.err
        reports.append(json.loads(done.out))
        assert not (tmp_path / way[0][2:] / "demonstrations").exists()
    stored, learned = reports
    edges = [e.name for e in DrawnLamp.graph.interactions]
    assert {stored["models"][e].pop("source") for e in edges} == {str(library)}
    assert {learned["models"][e].pop("source") for e in edges} == {"demonstrations"}
    for report in reports:
        report.pop("wall_seconds")
    assert stored == learned


def test_a_designers_skills_are_given_anew(library):
    edge = DrawnLamp.graph.interactions[0]
    own = {(edge, True): lambda states, attempt: states["hand"][None]}
    skills = Skills.of(load_graph(library, "lamp", DrawnLamp.graph), own)
    assert skills.own == own
    assert len(skills.activations[edge]) >= 3
    assert load_graph(library, "lantern", DrawnLamp.graph) is None


def test_a_library_that_holds_nothing_is_refused_before_anything_is_learned(ichain, demos, tmp_path):
    (tmp_path / "empty").mkdir()
    planned = ichain("plan", "lamp", "--physics", "ideal", "--library", tmp_path / "empty", "--demos", demos)
    assert planned.status == 2
    assert "empty: holds no interactions" in planned.line


@pytest.mark.parametrize("command", ["run", "plan", "learn", "teach", "evaluate"])
@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("learning.samples=20", "learning.samples is for scenarios that follow paths"),
        ("control.method=inverse", "control.method is for scenarios that follow paths"),
        ("learning.estimator=SVC", "learning.estimator SVC: it is no regressor"),
        ("learning.estimator=nix", "learning.estimator nix: there is no estimator 'nix'"),
    ],
)
def test_settings_that_are_not_for_goals_are_refused_in_one_line(ichain, command, setting, message, demos, tmp_path):
    more = {
        "learn": ("--demos", demos, "-o", tmp_path / "library"),
        "teach": ("-o", tmp_path / "demos"),
        "run": ("-o", tmp_path / "run"),
    }
    refused = ichain(command, "lamp", *more.get(command, ()), "--set", setting)
    assert refused.status == 2
    assert message in refused.line
    assert not list(tmp_path.iterdir())


def test_a_library_that_is_not_there_is_refused_before_anything_is_written(ichain, tmp_path):
    for command in (("run", "-o", tmp_path / "out"), ("plan",)):
        refused = ichain(command[0], "lamp", *command[1:], "--library", tmp_path / "nix")
        assert refused.status == 2
        assert "nix: can't be read as a folder" in refused.line
    assert not list(tmp_path.iterdir())


class Torch(sys.modules["lamp"].Lamp):  # type: ignore[misc, name-defined]
    """A lamp of another type, of which the library knows nothing."""

    state_space = ic.StateSpace("torch", (ic.Variable("light", "1", 0.0, 1.0),))


class TorchScenario(DrawnLamp):
    """The lamp's sliders before a torch."""

    name = "torch"
    kinds = DrawnLamp.kinds | {"lamp": Torch}
    spaces = DrawnLamp.spaces | {"lamp": Torch.state_space}
    graph = ic.InteractionGraph(spaces, [e.name for e in DrawnLamp.graph.interactions])


def test_each_interaction_that_fits_is_taken_and_the_rest_learned(ichain, library, tmp_path, monkeypatch):
    monkeypatch.setitem(SCENARIOS, "torch", TorchScenario)
    done = ichain("run", "torch", "--physics", "ideal", "--library", library, "-o", tmp_path, "--report", "-")
    assert done.status == 0, done.err
    assert "dimmer->lamp is learned: " in done.err
    report = json.loads(done.out)
    assert report["goal_reached"] is True
    models, folder = report["models"], str(library / "graph.lamp")
    found = {e.name: models[e.name]["source"] for e in TorchScenario.graph.interactions}
    assert found == {"hand->dimmer": folder, "hand->switch": folder} | dict.fromkeys(
        ("dimmer->lamp", "switch->lamp"), "demonstrations"
    )
    assert "why_learned" not in models["hand->dimmer"]
    assert "lamp: type: it is lamp, here it is torch" in models["switch->lamp"]["why_learned"]
    assert len(list((tmp_path / "demonstrations").iterdir())) >= 9
    demos = tmp_path / "demonstrations"
    planned = ichain("plan", "torch", "--physics", "ideal", "--library", library, "--demos", demos)
    assert planned.status == 0, planned.err
    assert "learning from 9 pieces" in planned.err


def test_nothing_is_lifted_out_of_no_library(ichain, tmp_path):
    done = ichain("run", "lamp", "--lift", "-o", tmp_path / "run")
    assert done.status == 2
    assert "--lift is for --library" in done.err


def test_what_the_demonstrations_contradict_is_learned_anew(ichain, library, tmp_path, monkeypatch):
    class Backward(sys.modules["lamp"].Lamp):  # type: ignore[misc, name-defined]
        def decide_active(self, state, parents, active, touch):
            return dict.fromkeys(active, bool(parents["switch"][0] < 0.42))

    class Lever(DrawnLamp.kinds["dimmer"]):  # type: ignore[misc]
        state_space = ic.StateSpace("lever", DrawnLamp.kinds["dimmer"].state_space.variables)

    class BackwardScenario(TorchScenario):
        name = "backward"
        kinds = DrawnLamp.kinds | {"lamp": Backward, "dimmer": Lever}
        spaces = DrawnLamp.spaces | {"dimmer": Lever.state_space}
        graph = ic.InteractionGraph(spaces, [e.name for e in DrawnLamp.graph.interactions])

    monkeypatch.setitem(SCENARIOS, "backward", BackwardScenario)
    planned = ichain("plan", "backward", "--physics", "ideal", "--library", library)
    assert planned.status == 0, planned.err
    said = planned.err.splitlines()
    assert any("switch->lamp is learned anew: its status is told with F1 0." in line for line in said)
    assert not any("hand->switch is learned" in line for line in said)


def test_a_damaged_graph_beside_is_refused(ichain, library, tmp_path, monkeypatch):
    monkeypatch.setitem(SCENARIOS, "torch", TorchScenario)
    assert ichain("library", "add", library, "--library", tmp_path / "L").status == 0
    (tmp_path / "L" / "graph.lamp" / "manifest.json").write_text("{}")
    refused = ichain("run", "torch", "--physics", "ideal", "--library", tmp_path / "L", "-o", tmp_path / "out")
    assert refused.status == 2
    assert "graph.lamp/manifest.json" in refused.line
    assert not (tmp_path / "out").exists()


@pytest.fixture
def dim(monkeypatch):
    """A lamp that can be made dimmer, so that one interaction isn't what it was."""

    class Dim(sys.modules["lamp"].Lamp):  # type: ignore[misc, name-defined]
        share = 1.0

        def step(self, state, parents, active, noise, dt):
            return self.share * super().step(state, parents, active, noise, dt)

    class DimLamp(DrawnLamp):
        def __init__(self, overrides=(), physics="ideal", seed=0):
            super().__init__([o for o in overrides if not o.startswith("lamp.")], physics, seed)
            share = float(next((o.partition("=")[2] for o in overrides if o.startswith("lamp.share")), 1.0))
            self.kinds = DrawnLamp.kinds | {"lamp": type("OneDim", (Dim,), {"share": share})}

    monkeypatch.setitem(SCENARIOS, "lamp", DimLamp)


def test_one_interaction_is_relearned_and_compared(ichain, dim, library, tmp_path):
    told = ichain("relearn", "lamp", "--physics", "ideal", "--link", "dimmer->lamp", "--library", library,
                  "--set", "lamp.share=0.8", "--report", tmp_path / "report.json")  # fmt: skip
    assert told.status == 0, told.err
    report = json.loads((tmp_path / "report.json").read_text())
    original, nothing, one, everything = report["rows"]
    assert [row["way"] for row in report["rows"]] == [
        "original", "changed, nothing relearned", "one link", "all links",
    ]  # fmt: skip
    assert (original["success"], one["success"], everything["success"]) == (True, True, True)
    assert not nothing["success"] or nothing["replans"] > one["replans"]
    assert (original["relearned"], nothing["relearned"], one["relearned"]) == ([], [], ["dimmer->lamp"])
    assert len(everything["relearned"]) == 4
    assert original["new_samples"] == nothing["robot_seconds"] == 0
    assert everything["robot_seconds"] >= one["robot_seconds"] > 0
    assert told.out.splitlines()[0].split() == [
        "learned", "anew", "goal", "reached", "control", "steps,", "median", "new", "plans,", "mean", "new", "samples",
        "robot", "(s)",
    ]  # fmt: skip
    assert report["table"][2]["reached"] == 1


def test_what_can_not_be_relearned_is_refused(ichain, library, tmp_path, monkeypatch):
    refused = ichain("relearn", "lamp", "--physics", "ideal", "--link", "hand->lamp", "--library", library)
    assert refused.status == 2
    assert "--link 'hand->lamp': the graph's interactions are hand->dimmer" in refused.line
    (tmp_path / "L").mkdir()
    refused = ichain("relearn", "lamp", "--physics", "ideal", "--link", "dimmer->lamp", "--library", tmp_path / "L")
    assert refused.status == 2
    assert "it has nothing that fits hand->dimmer (the library knows no such interaction)" in refused.line
    monkeypatch.setattr(DrawnLamp, "__init__", lambda self, *args: sys.modules["lamp"].LampScenario.__init__(self))
    refused = ichain("relearn", "lamp", "--physics", "ideal", "--link", "dimmer->lamp", "--library", library)
    assert refused.status == 2
    assert "lamp has no goal of its own to try" in refused.line


def test_of_several_unknown_interactions_one_alone_can_not_be_relearned(ichain, library, monkeypatch):
    monkeypatch.setitem(SCENARIOS, "torch", TorchScenario)
    told = ichain("relearn", "torch", "--physics", "ideal", "--link", "dimmer->lamp", "--library", library)
    assert told.status == 2
    assert "it has nothing that fits switch->lamp" in told.line
