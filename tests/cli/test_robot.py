"""`ichain robot` and `run --robot`: what is refused, each with one line, before anything is done."""

import pytest

from ichain_drake.cli.main import main
from ichain_drake.remote import link


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("robot car_game --pace 0", "--pace 0: give simulated seconds in a second"),
        ("robot car_game --seconds nan", "--seconds nan: give a time above 0"),
        ("robot car_game --lost 1.5", "--lost 1.5: a share of messages"),
        ("robot car_game --late -50", "--late -2: no message arrives before it was sent"),
        ("robot car_game --paths nowhere", "car_game has no path 'nowhere'"),
        ("robot car_game --address udp://1.2.3.4:5", "is no address of a robot; give one such as lcm://"),
        ("robot water_dispenser --paths eight", "is asked for a goal: --path and --paths are not for it"),
        ("run car_game --robot lcm://", "it can't be put back to a start; give one path"),
        ("run car_game --paths eight --robot lcm:// --oracle", "leave --oracle out"),
        ("run car_game --paths eight --robot lcm:// --meshcat", "shows a world in this process"),
    ],
)
def test_what_can_not_be_is_one_line(words: str, said: str, capfd: pytest.CaptureFixture[str]) -> None:
    command, system, *more = words.split()
    assert main([command, system, "--physics", "ideal", *more]) == 2
    err = capfd.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_a_run_without_its_robot_says_what_to_start_and_keeps_its_report(
    tmp_path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link, "_PATIENCE", 0.2)
    words = ["run", "car_game", "--physics", "ideal", "--paths", "eight", "--robot", "lcm://239.255.76.67:19999"]
    fast = ["--set", "learning.samples=60", "--set", "learning.estimator=polynomial(degree=1)"]
    assert main([*words, *fast, "--set", "control.efforts=[0.05]", "-o", str(tmp_path)]) == 1
    assert "no robot speaks there; first start `ichain robot SYSTEM`" in capfd.readouterr().err
    assert "no robot speaks there" in (tmp_path / "report.json").read_text()
