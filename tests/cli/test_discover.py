"""`ichain discover`, and `--unlabelled` with and without a graph."""

from dataclasses import replace
from pathlib import Path

import bath_log
import pytest
import yaml

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import write_demonstrations

BATH = str(Path(__file__).parents[2] / "examples" / "own_system" / "bath.py")


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """States alone, in a folder."""
    folder = tmp_path_factory.mktemp("logs")
    units = {f"{o}.{v.name}": v.unit for o, s in bath_log.GRAPH.objects.items() for v in s.variables}
    bare = [
        replace(p, table=p.table[[c for c in p.table.columns if "->" not in c]], units=units) for p in bath_log.pieces()
    ]
    write_demonstrations(bare, folder)
    return folder


def test_a_graph_is_discovered_and_its_spaces_are_confirmed(
    logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    file = tmp_path / "graph.yaml"
    assert main(["discover", str(logs), "-o", str(file), "--robot", "hand"]) == 0
    said = capsys.readouterr().out
    assert "hand->lever: sure by" in said
    written = yaml.safe_load(file.read_text())
    assert set(written["edges"]) == {"hand->lever", "lever->tank"}
    assert any("hand.x: in m; real, position" in line for line in written["guessed_so_confirm"])
    again = tmp_path / "again.yaml"
    assert main(["discover", str(logs), "-o", str(again), "--objects", str(file), "--forbid", "hand->tank"]) == 0
    assert set(yaml.safe_load(again.read_text())["edges"]) == {"hand->lever", "lever->tank"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "name it with --robot"),
        (("--robot", "spoon"), "no object 'spoon'"),
        (("--robot", "hand", "--no-cause", "spoon"), "no object 'spoon'"),
        (("--system", BATH, "--objects", "a.yaml"), "give one of the two"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(
    options: tuple[str, ...], message: str, logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["discover", str(logs), "-o", str(tmp_path / "g.yaml"), *options]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("ichain: ") and message in error
    assert not (tmp_path / "g.yaml").exists()


def test_no_graph_is_for_unlabelled(capsys: pytest.CaptureFixture) -> None:
    assert main(["plan", BATH, "--no-graph"]) == 2
    assert "--no-graph is for --unlabelled" in capsys.readouterr().err


def test_paths_need_no_flags(capsys: pytest.CaptureFixture) -> None:
    assert main(["run", "car_game", "--unlabelled"]) == 2
    assert "its links need no flags" in capsys.readouterr().err


def test_a_goal_is_reached_from_states_alone(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    options = ["--physics", "ideal", "--seed", "41000", "--unlabelled", "--no-graph", "-o", str(tmp_path)]
    assert main(["run", BATH, *options]) == 0
    assert "goal reached" in capsys.readouterr().out
    labels = yaml.safe_load((tmp_path / "report.json").read_text())["labels"]
    assert set(labels["edges"]) == {"hand->tap", "tap->basin"}
    assert all(e["open_rows"] > 0 for e in labels["edges"].values())


def test_labels_and_edges_are_evaluated(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    report = tmp_path / "report.json"
    options = ["--physics", "ideal", "--seed", "41000", "--trials", "1", "--report", str(report)]
    assert main(["evaluate", BATH, "--methods", "labels,edges", *options]) == 0
    lines = {line["method"]: line for line in yaml.safe_load(report.read_text())["table"]}
    assert lines["edges"]["mean_shd"] == 0
    assert lines["labels"]["f1_shown"] >= 0.97
    assert main(["evaluate", BATH, "--methods", "labels,slip", *options]) == 2
    assert "can't be evaluated beside" in capsys.readouterr().err
