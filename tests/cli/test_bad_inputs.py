"""Bad command lines made by chance: each ends with status 2 and exactly one line, before anything is recorded.

A few dozen run here; ICHAIN_BAD_INPUTS=1000 asks for as many.
"""

import json
import os
import random
import string
from collections.abc import Callable
from pathlib import Path

import pytest

from ichain_drake.scenarios.base import Scenario
from ichain_drake.systems import SCENARIOS

COUNT = int(os.environ.get("ICHAIN_BAD_INPUTS", "48"))
FOLLOWING = ("car_game", "hover_game", "driving", "ship")
ASKED = ("water_dispenser", "kettle", "microwave")
Maker = Callable[[random.Random, Path], list[str]]


def noise(rng: random.Random, least: int = 1) -> str:
    """Characters of many sorts, none of which a shell or the system can't hand on."""
    letters = string.ascii_letters + string.digits + " .,;:_-+*/=<>[](){}'\"\\|&%$#@!~^\u00e4\u00df\u4e2d\U0001f916\t\n"
    return "".join(rng.choice(letters) for _ in range(rng.randint(least, 30)))


def word(rng: random.Random) -> str:
    return "x" + "".join(rng.choice(string.ascii_lowercase) for _ in range(rng.randint(3, 9)))


def garbage(rng: random.Random) -> bytes:
    kind = rng.randrange(5)
    if kind == 0:
        return rng.randbytes(rng.randint(0, 300))
    if kind == 1:
        return noise(rng, 0).encode()
    if kind == 2:
        return b"x,y\n" + b"\n".join(noise(rng).encode() for _ in range(4))
    if kind == 3:
        return json.dumps([noise(rng), {word(rng): None}]).encode()
    return b"\x00" * rng.randint(1, 99)


def any_scenario(rng: random.Random) -> str:
    return rng.choice(FOLLOWING + ASKED)


def unknown_scenario(rng: random.Random, folder: Path) -> list[str]:
    command = rng.choice([["run"], ["plan"], ["graph"], ["settings"], ["evaluate"]])
    name = rng.choice([word(rng), word(rng) + ".py", f"{word(rng)}:{word(rng)}", "car_gam", "", "/", "..", "a:b:c"])
    return [*command, name]


def scenario_file(rng: random.Random, folder: Path) -> list[str]:
    file = folder / f"{word(rng)}.py"
    file.write_bytes(
        rng.choice(
            [
                b"import nothing_of_the_kind\n",
                b"x = (\n",
                b"raise SystemExit(3)\n",
                b"x = 1\n",
                b"1 / 0\n",
                b"\x00\xff",
                b"class A: pass\n",
            ]
        )
    )
    return [rng.choice(["run", "graph", "settings"]), str(file)]


def setting(rng: random.Random, folder: Path) -> list[str]:
    name = any_scenario(rng)
    keys = [
        "noise.scale",
        "robot.linear_speed",
        "robot.plant_step",
        "robot.gripper_kp",
        "learning.samples",
        "control.along",
    ]
    value = rng.choice(
        ["-1", ".nan", ".inf", "-.inf", "1e300", "text", "[1, 2]", "{a: 1}", "[", "&a [*a]", "2001-99-99", "''"]
    )
    wrong = rng.choice(
        [
            f"{rng.choice(keys)}={value}",
            f"{rng.choice(keys)}.{word(rng)}=1",
            f"{word(rng)}={value}",
            noise(rng).replace("=", "") or "x",
            f"noise.{word(rng)}=1",
            "fault.kind=" + word(rng),
            f"robot.home.x={rng.choice(['.nan', '.inf', 'left'])}",
            "robot={}=1",
            "noise=[]",
            "=",
            "robot.hand.surface={radius: 0}",
            "robot.kp=[]",
            "robot.ik_rate=1.5",
        ]
    )
    return [
        rng.choice(["run", "evaluate", "teach"]),
        name,
        "--physics",
        "ideal",
        "-o",
        str(folder / "out"),
        "--set",
        wrong,
    ]


def option(rng: random.Random, folder: Path) -> list[str]:
    name = any_scenario(rng)
    wrong = rng.choice(
        [
            ["--" + word(rng)],
            ["--physics", word(rng)],
            ["--seed", rng.choice(["-1", "x", "1.5", "nan", ""])],
            ["--set"],
            ["--physics"],
            ["-q"],
            [word(rng)],
            ["--realtime"],
        ]
    )
    return ["run", name, *wrong]


def command(rng: random.Random, folder: Path) -> list[str]:
    return rng.choice(
        [
            [word(rng)],
            [],
            ["library"],
            ["library", word(rng)],
            ["run"],
            ["play"],
            ["teach", "car_game"],
            ["learn", "car_game"],
            ["relearn", "car_game"],
            ["play", str(folder / word(rng))],
            ["settings"],
            ["graph", "car_game", "-o", str(folder / ("a." + word(rng)))],
        ]
    )


def path_file(rng: random.Random, folder: Path) -> list[str]:
    file = folder / f"{word(rng)}.csv"
    points = [(rng.uniform(-1e4, -1), rng.uniform(-1e4, 1e4)) for _ in range(rng.randint(2, 9))]
    file.write_bytes(
        rng.choice(
            [
                garbage(rng),
                b"x,y\n" + "\n".join(f"{x},{y}" for x, y in points).encode(),
                b"x,y\n1,2\n",
                b"x,y\n1,2\n1,2\n",
                b"x,y\nnan,2\n3,4\n",
                b"x\n1\n2\n",
                b"",
            ]
        )
    )
    given = rng.choice([str(file), str(folder), str(folder / word(rng))])
    return ["run", rng.choice(FOLLOWING), "--physics", "ideal", "-o", str(folder / "out"), "--path", given]


def path_name(rng: random.Random, folder: Path) -> list[str]:
    return ["run", rng.choice(FOLLOWING), "-o", str(folder / "out"), "--paths", rng.choice([word(rng), noise(rng), ""])]


def goal(rng: random.Random, folder: Path) -> list[str]:
    name = rng.choice(ASKED)
    parts = [
        "cup.water",
        "bottle.water",
        ">=",
        "<=",
        ">",
        "==",
        "0.5",
        "-1",
        "nan",
        "and",
        "not",
        "hand->",
        "->cup",
        word(rng),
        "keep",
        "within",
        "start",
        "...",
        "hand.x",
    ]
    text = " ".join([word(rng) + "." + word(rng), *(rng.choice(parts) for _ in range(rng.randint(0, 5)))])
    text = rng.choice([text, noise(rng), "", "   "])
    return [rng.choice(["run", "plan"]), name, "--physics", "ideal", "--goal", text]


def demonstrations(rng: random.Random, folder: Path) -> list[str]:
    pieces = folder / word(rng)
    if rng.random() < 0.8:
        pieces.mkdir()
        for _ in range(rng.randint(0, 2)):
            (pieces / f"{word(rng)}{rng.choice(['.csv', '.parquet', '.txt'])}").write_bytes(garbage(rng))
    name = any_scenario(rng)
    command = rng.choice([["run", name, "-o", str(folder / "out")], ["learn", name, "-o", str(folder / "out")]])
    extra = ["--physics", "ideal"] if command[0] == "run" else []
    return [*command, *extra, "--demos", str(pieces)]


def library(rng: random.Random, folder: Path) -> list[str]:
    place = folder / word(rng)
    if rng.random() < 0.8:
        place.mkdir()
        for name in rng.sample(["manifest.json", "a.npz", "hand-joystick", "links"], rng.randint(0, 3)):
            if rng.random() < 0.7:
                (place / name).write_bytes(garbage(rng))
            else:
                (place / name).mkdir()
    shown = ["library", "show", rng.choice([word(rng), noise(rng)]), "--library", str(place)]
    return rng.choice(
        [
            shown,
            ["library", "add", str(place), "--library", str(folder / "other")],
            [
                "run",
                rng.choice(FOLLOWING[:2]),
                "--physics",
                "ideal",
                "-o",
                str(folder / "out"),
                "--library",
                str(place),
            ],
        ]
    )


def output(rng: random.Random, folder: Path) -> list[str]:
    file = folder / word(rng)
    file.write_bytes(b"")
    wrong = rng.choice(
        [
            ["-o", str(file)],
            ["--record", str(folder / "a.txt")],
            ["--report", str(folder)],
            ["-o", str(file / "inside")],
            ["--record", "x" * 300 + ".html"],
            ["--report", "/proc/1/x/y"],
            ["-o", "\0"],
        ][:6]
    )
    rest = [] if wrong[0] == "-o" else ["-o", str(folder / "out")]
    return ["run", any_scenario(rng), "--physics", "ideal", *rest, *wrong]


def estimator(rng: random.Random, folder: Path) -> list[str]:
    text = rng.choice(
        [
            word(rng),
            "polynomial(degree=60)",
            "Ridge(alpha=-1)",
            "polynomial(",
            f"Ridge({word(rng)}=1)",
            "BaggingRegressor",
            "MultiOutputRegressor(estimator='Ridge')",
            "RidgeCV(alphas=[])",
            "__import__('os')",
            noise(rng),
        ]
    )
    return [
        "run",
        any_scenario(rng),
        "--physics",
        "ideal",
        "-o",
        str(folder / "out"),
        "--set",
        f"learning.estimator={text}",
    ]


def evaluation(rng: random.Random, folder: Path) -> list[str]:
    wrong = rng.choice(
        [["--methods", word(rng)], ["--trials", "0"], ["--trials", "x"], ["--jobs", "0"], ["--jobs", "-3"]]
    )
    return ["evaluate", any_scenario(rng), "--physics", "ideal", *wrong]


def link(rng: random.Random, folder: Path) -> list[str]:
    return [
        "relearn",
        rng.choice(FOLLOWING),
        "--physics",
        "ideal",
        "--link",
        rng.choice([word(rng), "a->b", noise(rng), "->"]),
        "--library",
        str(folder / word(rng)),
    ]


def looked_at(rng: random.Random, folder: Path) -> list[str]:
    pieces = folder / word(rng)
    if rng.random() < 0.8:
        pieces.mkdir()
        for _ in range(rng.randint(0, 3)):
            (pieces / f"{word(rng)}{rng.choice(['.csv', '.parquet', '.csv.gz', '.npz'])}").write_bytes(garbage(rng))
    more = rng.choice([[], [], ["--system", word(rng)], ["--page", str(folder / "a.txt")], ["--report", str(folder)]])
    return ["check", str(pieces), *more]


def report(rng: random.Random, folder: Path) -> list[str]:
    file = folder / word(rng)
    file.write_bytes(garbage(rng))
    return rng.choice(
        [
            ["scoreboard", "--against", str(file)],
            ["scoreboard", "--against", str(folder)],
            ["scoreboard", "--jobs", "0"],
            ["scoreboard", "--also", noise(rng).lstrip("-") or "x"],
            ["benchmarks", "--report", str(folder)],
            ["benchmarks", "--report", str(file / "inside")],
        ]
    )


MAKERS: tuple[Maker, ...] = (
    looked_at,
    report,
    unknown_scenario,
    scenario_file,
    setting,
    option,
    command,
    path_file,
    path_name,
    goal,
    demonstrations,
    library,
    output,
    estimator,
    evaluation,
    link,
)


@pytest.fixture(autouse=True)
def nothing_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Scenario, *arguments: object) -> None:
        raise AssertionError("something was recorded")

    for kind in SCENARIOS.values():
        monkeypatch.setattr(kind, "record_demonstrations", fail)


@pytest.mark.parametrize("number", range(COUNT))
def test_one_line_and_status_2(number: int, ichain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    rng = random.Random(number)
    arguments = MAKERS[number % len(MAKERS)](rng, tmp_path)
    done = ichain(*arguments)
    assert done.status == 2, (arguments, done)
    if arguments[:1] not in ([], ["library"]) or len(arguments) > 1:  # those print their help
        assert done.line.isprintable(), (arguments, done)
        assert len(done.line) < 2500, (arguments, done)
        assert "not foreseen" not in done.line, (arguments, done)
    assert not list(tmp_path.glob("out/*/*.parquet"))
