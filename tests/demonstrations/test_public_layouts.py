"""Logs as public data sets of people driving and manipulating lay them out, made small here.

As they are, they are refused with what is missing; with columns named as this library asks, they are read: units,
rates, gaps and clocks as they come. Columns, units and rates are those of the data sets' own descriptions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration, read_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

ROAD = InteractionGraph(
    {
        "driver": StateSpace("driver", (Variable("wheel", "rad", -10, 10), Variable("pedal", "1", 0, 1))),
        "car": StateSpace(
            "car", (Variable("x", "m"), Variable("y", "m"), Variable("yaw", "rad", -np.pi, np.pi, "angle"))
        ),
    },
    ["driver->car"],
)
TABLE = InteractionGraph(
    {
        "hand": StateSpace("hand", (Variable("x", "m"), Variable("y", "m"), Variable("grip", kind="binary"))),
        "block": StateSpace("block", (Variable("x", "m"), Variable("y", "m"))),
    },
    ["hand->block"],
)
ROWS = np.arange(61)


def ngsim() -> pd.DataFrame:
    """Vehicles of a road: 10 Hz, milliseconds since 1970, feet."""
    return pd.concat(
        pd.DataFrame(
            {
                "Vehicle_ID": vehicle, "Frame_ID": 270 + ROWS, "Total_Frames": len(ROWS),
                "Global_Time": 1118846980200 + 100 * ROWS, "Local_X": 16.5 + 0.1 * ROWS, "Local_Y": 35.4 + 4.0 * ROWS,
                "v_Length": 14.3, "v_Width": 6.4, "v_Class": 2, "v_Vel": 40.0, "v_Acc": 0.0, "Lane_ID": 2,
                "Preceding": 0, "Following": 13, "Space_Headway": 0.0, "Time_Headway": 9999.99,
            }
        )
        for vehicle in (2, 13)
    )  # fmt: skip


def highd() -> pd.DataFrame:
    """Tracks seen from above: 25 Hz, frames in place of times, metres."""
    return pd.concat(
        pd.DataFrame(
            {
                "frame": 1 + ROWS, "id": track, "x": 362.26 + 1.634 * ROWS, "y": 21.68, "width": 4.85, "height": 2.12,
                "xVelocity": 40.85, "yVelocity": 0.0, "xAcceleration": 0.3, "yAcceleration": 0.0,
                "frontSightDistance": 53.0, "backSightDistance": 366.0, "dhw": 0.0, "thw": 0.0, "ttc": 0.0,
                "laneId": 5,
            }
        )
        for track in (1, 2)
    )  # fmt: skip


def interaction() -> pd.DataFrame:
    """Tracks at crossings: 10 Hz, milliseconds, radians."""
    return pd.DataFrame(
        {
            "track_id": 1, "frame_id": 1 + ROWS, "timestamp_ms": 100 + 100 * ROWS, "agent_type": "car",
            "x": 1000.0 + 0.8 * ROWS, "y": 990.0, "vx": 8.0, "vy": 0.0, "psi_rad": 0.02, "length": 4.5, "width": 1.8,
        }
    )  # fmt: skip


def lerobot() -> pd.DataFrame:
    """Pushing a T: vectors in cells, 10 Hz, pixels."""
    return pd.DataFrame(
        {
            "observation.state": [np.array([220.0 + r, 90.0], np.float32) for r in ROWS],
            "action": [np.array([233.0 + r, 71.0], np.float32) for r in ROWS],
            "episode_index": 0, "frame_index": ROWS, "timestamp": np.float32(ROWS / 10), "next.reward": 0.1,
            "next.done": False, "next.success": False, "index": ROWS, "task_index": 0,
        }
    )  # fmt: skip


def write(folder: Path, table: pd.DataFrame, name: str = "log.csv") -> Path:
    if name.endswith(".parquet"):
        table.to_parquet(folder / name, index=False)
    else:
        table.to_csv(folder / name, index=False)
    return folder


OXTS = "49.015 8.434 112.83 0.03 0.01 -1.58 -13.1 -0.2 13.2 0.1 0.0 0.4 0.2 9.8 0.4 0.1 9.8" + " 0" * 13
REFUSED = {
    "NGSIM": (ngsim, "log.csv", "time is missing; rename Global_Time, .*; rows of each Vehicle_ID need a file"),
    "highD": (highd, "log.csv", "time is missing; make it of frame, divided by the rate.*rows of each id need a file"),
    "INTERACTION": (interaction, "log.csv", "time is missing; rename timestamp_ms, .*or name its unit"),
    "LeRobot": (lerobot, "episode_000000.parquet", "this is a table of LeRobot; read its data set by .ichain import"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_as_it_is_it_is_refused_with_what_is_missing(name: str, tmp_path: Path) -> None:
    make, file, match = REFUSED[name]
    with pytest.raises(InputError, match=match) as caught:
        read_demonstrations(write(tmp_path, make(), file), ROAD, resampled=True)
    assert len(str(caught.value)) < 600


def test_numbers_without_names_and_formats_that_are_none_of_ours(tmp_path: Path) -> None:
    """KITTI's files of one row each, and the HDF5 of robomimic, RoboTurk and D4RL."""
    (tmp_path / "0000000000.txt").write_text(OXTS + "\n")
    (tmp_path / "low_dim.hdf5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(99))
    said: list[str] = []
    with pytest.raises(InputError, match=r"holds no demonstration .*beside it there is 0000000000\.txt, low_dim\.hdf5"):
        read_demonstrations(tmp_path, ROAD, say=said.append)
    assert said == []  # the one line says it
    (tmp_path / "oxts.csv").write_text(f"{OXTS}\n{OXTS}\n".replace(" ", ","))
    with pytest.raises(InputError, match=r"its first line is '49\.015,8\.434.*a header is needed"):
        read_demonstrations(tmp_path, ROAD, say=said.append)
    assert said == ["passed over: low_dim.hdf5 (neither .parquet nor .csv)"]
    (tmp_path / "oxts.csv").write_bytes((tmp_path / "low_dim.hdf5").read_bytes())
    with pytest.raises(InputError, match="it is HDF5, not text"):
        read_demonstrations(tmp_path, ROAD)


def resampled(folder: Path, graph: InteractionGraph) -> tuple[list[Demonstration], list[str]]:
    said: list[str] = []
    with pytest.raises(InputError, match="--resample|not a finite number"):
        read_demonstrations(folder, graph)
    return read_demonstrations(folder, graph, resampled=True, say=said.append), said


def test_feet_and_milliseconds(tmp_path: Path) -> None:
    track = ngsim().query("Vehicle_ID == 2")
    table = pd.DataFrame(
        {"time [ms]": track.Global_Time, "car.x [ft]": track.Local_Y, "car.y [ft]": track.Local_X, "car.yaw": 0.02}
    )
    (piece,), said = resampled(write(tmp_path, table), ROAD)
    assert len(piece) == 19
    np.testing.assert_allclose(np.diff(piece.table["car.x"]), 0.3048 * 40.0 * TICK, rtol=1e-6)
    assert any("car.x converted from ft to m" in line for line in said)


def test_frames_divided_by_their_rate(tmp_path: Path) -> None:
    track = highd().query("id == 1")
    heading = np.arctan2(track.yVelocity, track.xVelocity)
    table = pd.DataFrame({"time": track.frame / 25, "car.x": track.x, "car.y": track.y, "car.yaw": heading})
    (piece,), _ = resampled(write(tmp_path, table, "01_tracks.CSV"), ROAD)
    np.testing.assert_allclose(np.diff(piece.table["car.x"]), 40.85 * TICK, rtol=1e-9)


def test_moments_with_jitter_and_headings_past_half_a_turn(tmp_path: Path) -> None:
    """KITTI's timestamps: nanoseconds in text, 10 Hz and some milliseconds off."""
    late = 0.004 * np.random.default_rng(2).standard_normal(len(ROWS))
    moments = pd.Timestamp("2011-09-26 13:02:25.964389445") + pd.to_timedelta(ROWS / 10 + late, unit="s")
    yaw = (3.0 + 0.02 * ROWS + np.pi) % (2 * np.pi) - np.pi
    table = pd.DataFrame({"time": moments.astype(str), "car.x": 1.3 * ROWS, "car.y": 0.0, "car.yaw": yaw})
    (piece,), _ = resampled(write(tmp_path, table), ROAD)
    turned = np.diff(np.unwrap(piece.table["car.yaw"]))
    np.testing.assert_allclose(turned, 0.2 * TICK, atol=0.005)


def test_two_rates_and_an_hour_between(tmp_path: Path) -> None:
    """Of a car's bus as in comma2k19: steering at 80 Hz in degrees, poses at 20 Hz, segments of one minute."""
    times = np.concatenate([np.arange(0, 5, 1 / 80), 3600 + np.arange(0, 5, 1 / 80)])
    seldom = np.arange(len(times)) % 4 != 0
    table = pd.DataFrame(
        {
            "time": times, "driver.wheel [deg]": 30.0 * np.sin(times), "driver.pedal [%]": 20.0,
            "car.x": np.where(seldom, np.nan, 13.0 * times), "car.y": np.where(seldom, np.nan, 0.0),
            "car.yaw": np.where(seldom, np.nan, 0.1),
        }
    )  # fmt: skip
    pieces, said = resampled(write(tmp_path, table), ROAD)
    assert len(pieces) == 2
    assert any("split at gaps" in line for line in said)
    for piece in pieces:
        assert np.abs(piece.table["driver.wheel"]).max() <= np.deg2rad(30.0)
        np.testing.assert_allclose(piece.table["driver.pedal"], 0.2)
        np.testing.assert_allclose(np.diff(piece.table["car.x"]), 13.0 * TICK, rtol=1e-6)


@pytest.mark.parametrize(("rate", "ending"), [(20.0, ".parquet"), (12.5, ".csv.gz"), (5.0, ".csv")])
def test_manipulation_at_its_rates(rate: float, ending: str, tmp_path: Path) -> None:
    """robomimic records at 20 Hz, D4RL's kitchen at 12.5, BridgeData at 5; a gripper is open or shut, never between."""
    times = np.arange(0, 8, 1 / rate)
    table = pd.DataFrame(
        {
            "time": times, "hand.x": 0.1 * times, "hand.y": 0.0, "hand.grip": (times > 3.1).astype(float),
            "block.x": 0.1 * np.maximum(times, 3.1), "block.y": 0.0, "hand->block": (times > 3.1).astype(int),
        }
    )  # fmt: skip
    (piece,), _ = resampled(write(tmp_path, table, f"demo_0{ending}"), TABLE)
    assert set(piece.table["hand.grip"]) == {0.0, 1.0}
    assert (piece.table["hand->block"] == piece.table["hand.grip"]).all()
    np.testing.assert_allclose(np.diff(piece.table["hand.x"]), 0.1 * TICK, rtol=1e-6)


def test_vectors_split_into_columns(tmp_path: Path) -> None:
    """LeRobot's table of pushing, as its error asks for: pixels are no metres, and a scale makes them so."""
    frame = lerobot()
    state = np.stack(list(frame["observation.state"]))
    table = pd.DataFrame({"time": frame.timestamp, "block.x [px]": state[:, 0], "block.y [px]": state[:, 1]})
    with pytest.raises(
        InputError, match=r"column block\.x is in px, but m is needed, and there is no way from px to m"
    ):
        read_demonstrations(write(tmp_path, table), TABLE, resampled=True)
    scaled = pd.DataFrame({"time": frame.timestamp, "block.x": state[:, 0] / 512, "block.y": state[:, 1] / 512})
    (piece,), _ = resampled(write(tmp_path, scaled), TABLE)
    assert len(piece) == 19
