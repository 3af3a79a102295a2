"""Command lines that can't be, drawn at random, without any file: names, options, settings, goals, estimators."""

from __future__ import annotations

import random
import string
from collections.abc import Callable
from pathlib import Path

FOLLOWING = ("car_game", "hover_game", "driving", "ship")
ASKED = ("water_dispenser", "kettle", "microwave")
Maker = Callable[[random.Random, Path], list[str]]
"""From a generator and a folder of its own, the arguments of a command that must be refused."""


def noise(rng: random.Random, least: int = 1) -> str:
    """Characters of many sorts, none of which a shell or the system can't hand on."""
    letters = string.ascii_letters + string.digits + " .,;:_-+*/=<>[](){}'\"\\|&%$#@!~^\u00e4\u00df\u4e2d\U0001f916\t\n"
    return "".join(rng.choice(letters) for _ in range(rng.randint(least, 30)))


def word(rng: random.Random) -> str:
    return "x" + "".join(rng.choice(string.ascii_lowercase) for _ in range(rng.randint(3, 9)))


def any_scenario(rng: random.Random) -> str:
    return rng.choice(FOLLOWING + ASKED)


def unknown_scenario(rng: random.Random, folder: Path) -> list[str]:
    command = rng.choice([["run"], ["plan"], ["graph"], ["settings"], ["evaluate"]])
    name = rng.choice([word(rng), word(rng) + ".py", f"{word(rng)}:{word(rng)}", "car_gam", "", "/", "..", "a:b:c"])
    return [*command, name]


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


def clustered(rng: random.Random, folder: Path) -> list[str]:
    wrong = rng.choice(
        [["--cluster", word(rng)], ["--cluster", "dask=" + noise(rng)], ["--without", word(rng)], ["--seed", "-4"],
         ["--trials", "-1"], ["--trial-timeout", rng.choice(["-1", "0", "nan"])]]
    )  # fmt: skip
    return [*rng.choice([["evaluate", any_scenario(rng), "--physics", "ideal"], ["scoreboard"]]), *wrong]


def profiled(rng: random.Random, folder: Path) -> list[str]:
    return rng.choice(
        [
            ["benchmarks", "--profile", word(rng)],
            ["benchmarks", "--set", "noise.scale=1"],
            ["benchmarks", "--profile", "car_game", "--physics", word(rng)],
            ["benchmarks", "--profile", "car_game", "--set", word(rng) + "=1"],
            ["list", word(rng)],
            ["teach", any_scenario(rng), "-o", str(folder), "--drive", word(rng)],
            ["teach", any_scenario(rng), "-o", str(folder), "--browser", "--drive", word(rng)],
        ]
    )


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


MAKERS: tuple[Maker, ...] = (
    unknown_scenario, setting, option, command, path_name, goal, estimator, evaluation, clustered, profiled, link,
)  # fmt: skip
