"""Command lines with files that can't be used, drawn at random: paths, pieces, logs, libraries, places to write."""

from __future__ import annotations

import json
import random
from pathlib import Path

from bad_words import ASKED, FOLLOWING, Maker, any_scenario, noise, word


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


def logs(rng: random.Random, folder: Path) -> list[str]:
    """Logs of other tools, there and back."""
    source, chart = folder / word(rng), folder / "map.yaml"
    if rng.random() < 0.5:
        source.mkdir()
        for name in rng.sample(["meta", "data", "a.mcap", "a.db3", "metadata.yaml", "a.csv"], rng.randint(0, 3)):
            (source / name).write_bytes(garbage(rng))
    elif rng.random() < 0.8:
        source.write_bytes(garbage(rng))
    good = b'columns: {"obs/x[0]": hand.x, "/a:b": cup.x, "state[0]": "cup.y [mm]"}\nrate: 20\n'
    bad = (b"columns: 1", b"columns: {}", b"columns: {a: b}", b"rate: -1", good + b"time: 3\n", good + b"rate: x\n")
    chart.write_bytes(rng.choice([good, good, good, *bad, garbage(rng)]))
    form = rng.choice(["lerobot", "mcap", "minari", "robomimic", "ros2", word(rng), ""])
    if rng.random() < 0.3:
        return ["export", form, str(source), "-o", str(folder / "out")]
    more = rng.choice([[], [], ["--resample"], ["--system", word(rng)], ["--system", "kettle"]])
    return ["import", form, str(source), "--map", str(chart), "-o", str(folder / "out"), *more]


def discovered(rng: random.Random, folder: Path) -> list[str]:
    """Logs without flags and graphs in files."""
    pieces, graph = folder / word(rng), folder / "graph.yaml"
    if rng.random() < 0.8:
        pieces.mkdir()
        (pieces / "a.csv").write_bytes(rng.choice([garbage(rng), b"time,a.x,b.x\n0,1,2\n0.3333,1,2\n"]))
    bad = (b"objects: {}", b"edges: [a->b]", b"interactions: [1]", b"objects: {a: {x: [m, 2, 1]}}", b"[", b"")
    graph.write_bytes(rng.choice([*bad, garbage(rng)]))
    name = rng.choice(ASKED)
    more = rng.choice([[], ["--objects", str(graph)], ["--robot", word(rng)], ["--system", word(rng)],
                       ["--require", noise(rng)], ["--forbid", "a->b"], ["--no-cause", word(rng)]])  # fmt: skip
    given = ["--demos", str(pieces), "--unlabelled", "--graph", str(graph)]
    return rng.choice(
        [
            ["discover", str(pieces), "-o", str(folder / "g.yaml"), *more],
            ["run", name, "--physics", "ideal", "-o", str(folder / "out"), *given],
            ["plan", name, "--physics", "ideal", *given],
            ["learn", name, "-o", str(folder / "out"), *given],
        ]
    )


def taken(rng: random.Random, folder: Path) -> list[str]:
    """Libraries that are taken from by the other commands."""
    place = folder / word(rng)
    for part in rng.sample(["hand-joystick", "cup", "x"], rng.randint(0, 2)):
        (place / part).mkdir(parents=True)
        good = json.dumps({"format": rng.choice([1, 2, 3, "x"]), "kind": rng.choice(["graph", "link", 1]), "files": {}})
        (place / part / "manifest.json").write_bytes(rng.choice([garbage(rng), good.encode()]))
        (place / part / rng.choice(["weights.npz", "forward.npz", "a.pkl"])).write_bytes(garbage(rng))
    name, library = rng.choice(["hand-joystick", "cup", word(rng), ".."]), ["--library", str(place)]
    return rng.choice(
        [
            ["library", "export", name, *library, "-o", str(folder / "out")],
            ["library", "show", name, *library],
            ["relearn", "car_game", "--physics", "ideal", "--link", "hand->joystick", *library],
            ["plan", "kettle", "--physics", "ideal", *library, "--goal", word(rng)],
        ]
    )


MAKERS: tuple[Maker, ...] = (
    looked_at, report, scenario_file, path_file, demonstrations, library, output, logs, discovered, taken,
)  # fmt: skip
