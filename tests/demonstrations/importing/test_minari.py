"""Minari data sets, made by Minari itself, and some that are not meant well."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.errors import InputError

h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
minari = pytest.importorskip("minari", reason="Minari is missing: pip install 'ichain_drake[minari]'")

from gymnasium.spaces import Box, Dict, Discrete, Space, Tuple  # noqa: E402
from minari.data_collector import EpisodeBuffer  # noqa: E402

STEPS = 4


def box(size: int, kind: type = np.float64) -> Box:
    return Box(-np.inf, np.inf, (size,), kind)


def made(folder: Path, spaces: tuple[Space, Space], episodes: list[tuple], **how: str) -> Path:
    """A data set of episodes, each of observations and actions."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MINARI_DATASETS_PATH", str(folder))
        buffers = [
            EpisodeBuffer(
                id=i, observations=seen, actions=done, rewards=[0.5] * STEPS,
                terminations=[False] * STEPS, truncations=[False] * (STEPS - 1) + [True],
            )
            for i, (seen, done) in enumerate(episodes)
        ]  # fmt: skip
        with pytest.warns(UserWarning):  # that nobody wrote it
            minari.create_dataset_from_buffers(
                "cup/pour-v0", buffers, observation_space=spaces[0], action_space=spaces[1], **how
            )
    return folder / "cup" / "pour-v0"


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng = np.random.default_rng(0)
    episodes = [(rng.standard_normal((STEPS + 1, 3)), rng.standard_normal((STEPS, 2))) for _ in range(11)]
    return made(tmp_path_factory.mktemp("flat"), (box(3), box(2)), episodes)


@pytest.fixture
def own(flat: Path, tmp_path: Path) -> Path:
    """A copy that may be damaged."""
    return Path(shutil.copytree(flat, tmp_path / "set"))


def told(source: Path, columns: dict[str, str], **more: object) -> str:
    with pytest.raises(InputError) as error:
        import_logs("minari", source, parse_map({"columns": columns, "rate": 3, **more}, "m"))
    assert "\n" not in str(error.value)
    return str(error.value)


def test_every_episode_is_a_piece_and_the_last_action_is_still_in_force(flat: Path) -> None:
    mapping = parse_map({"columns": {"observations[2]": "cup.x [m]", "actions[1]": "command.x"}, "rate": 10}, "m")
    pieces = import_logs("minari", flat, mapping)
    assert [p.name for p in pieces] == [f"episode_{i}" for i in range(11)]
    with h5py.File(flat / "data" / "main_data.hdf5") as file:
        seen, done = file["episode_10/observations"][()], file["episode_10/actions"][()]
    np.testing.assert_array_equal(pieces[10].table["cup.x"], seen[:, 2])
    np.testing.assert_array_equal(pieces[10].table["command.x"], [*done[:, 1], done[-1, 1]])
    np.testing.assert_allclose(pieces[10].table["time"], np.arange(STEPS + 1) / 10)
    assert pieces[10].units == {"cup.x": "m"}
    for other in (flat / "data", flat / "data" / "main_data.hdf5"):
        assert len(import_logs("minari", other, mapping)) == 11


def test_dictionaries_tuples_and_numbers(tmp_path: Path) -> None:
    spaces = Dict(cup=box(2, np.float32), arm=Tuple((box(1), Discrete(3)))), Dict(grip=Discrete(2))
    rng = np.random.default_rng(0)
    cup = rng.standard_normal((STEPS + 1, 2)).astype(np.float32)
    level = np.array([0, 1, 2, 1, 0])
    seen = {"cup": cup, "arm": (rng.standard_normal((STEPS + 1, 1)), level)}
    folder = made(tmp_path, spaces, [(seen, {"grip": np.array([0, 1, 1, 0])})])
    columns = {"observations/cup[1]": "cup.y", "observations/arm/_index_1": "arm.level", "actions/grip": "command.grip"}
    (piece,) = import_logs("minari", folder, parse_map({"columns": columns, "rate": 3}, "m"))
    np.testing.assert_array_equal(piece.table["cup.y"], cup[:, 1].astype(float))
    np.testing.assert_array_equal(piece.table["arm.level"], level)
    np.testing.assert_array_equal(piece.table["command.grip"], [0, 1, 1, 0, 0])
    assert "observations/cup has 2 numbers; say which" in told(folder, {"observations/cup": "cup.x"})
    assert "it has no data set observations/arm" in told(folder, {"observations/arm": "cup.x"})


def test_times_come_from_the_map(flat: Path) -> None:
    timed = parse_map({"columns": {"observations[0]": "cup.x"}, "time": "observations[1]"}, "m")
    with h5py.File(flat / "data" / "main_data.hdf5") as file:
        times = file["episode_3/observations"][:, 1]
    np.testing.assert_array_equal(import_logs("minari", flat, timed)[3].table["time"], times - times[0])
    with pytest.raises(InputError, match="Minari doesn't tell how far apart rows are; give rate"):
        import_logs("minari", flat, parse_map({"columns": {"actions[0]": "cup.x"}}, "m"))


def test_what_is_no_data_set_is_told(own: Path, tmp_path: Path) -> None:
    assert "episode_0: it has no data set states; it has actions" in told(own, {"states": "cup.x"})
    assert "there is no such file" in told(tmp_path / "none", {"actions": "cup.x"})
    assert "data/main_data.hdf5 is missing" in told(tmp_path, {"actions": "cup.x"})
    with h5py.File(own / "data" / "main_data.hdf5", "w") as file:
        file.create_group("other")
    assert "it holds no episode" in told(own, {"actions": "cup.x"})
    (own / "data" / "main_data.hdf5").write_bytes(b"no HDF5")
    assert "can't read it as HDF5" in told(own, {"actions": "cup.x"})
    arrow = made(tmp_path / "a", (box(1), box(1)), [(np.zeros((5, 1)), np.zeros((4, 1)))], data_format="arrow")
    assert "of Minari's formats hdf5 is read" in told(arrow, {"actions": "cup.x"})


def test_links_claims_and_rows_that_do_not_fit_are_refused(own: Path) -> None:
    with h5py.File(own / "data" / "main_data.hdf5", "a") as file:
        episode = file["episode_0"]
        episode["outside"] = h5py.ExternalLink(str(own / "secret.hdf5"), "/d")
        episode["soft"] = h5py.SoftLink("/episode_1/actions")
        episode.create_dataset("huge", (10**12,), "f8", chunks=(1000,))
        episode["short"] = np.ones(STEPS - 1)
        episode["none"] = np.ones(0)
    for name in ("outside", "soft"):
        assert f"{name} is a link to somewhere else" in told(own, {name: "cup.x"})
    assert "huge claims 1000000000000 numbers" in told(own, {"huge": "cup.x"})
    assert "its data sets have 3, 5 rows" in told(own, {"short": "cup.x", "observations[0]": "cup.y"})
    assert "its data sets have 3, 4, 5 rows" in told(
        own, {"short": "cup.x", "observations[0]": "cup.y", "actions[0]": "cup.z"}
    )
    assert "none has no rows" in told(own, {"none": "cup.x"})
    with h5py.File(own / "data" / "main_data.hdf5", "a") as file:
        del file["episode_1"]
        file["episode_1"] = h5py.ExternalLink("other.hdf5", "/episode_1")
    assert "episode_1 is a link to somewhere else" in told(own, {"actions[0]": "cup.x"})
