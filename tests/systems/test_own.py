"""A scenario by file or module: which class is meant, and what is said where there is none."""

import importlib
import sys
from pathlib import Path

import pytest

from ichain_drake.cli.main import main
from ichain_drake.errors import InputError
from ichain_drake.systems import load_scenario
from ichain_drake.systems.kettle.scenario import KettleScenario
from ichain_drake.systems.own import is_own, own_scenario

COMPLETE = '''
import ichain_drake as ic

class {name}(ic.GraphScenario):
    """A hand with nothing to do."""

    name = "{label}"

    def make_graph(self):
        return ic.InteractionGraph({{"hand": self.config.robot.hand.space}}, [])

    def draw_start(self, rng):
        return None

    def make_objects(self, start, make):
        return {{}}

    def script(self, rng):
        yield from ()
'''


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory; what is imported from it is forgotten again."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    monkeypatch.chdir(tmp_path)
    importlib.invalidate_caches()
    return tmp_path


def write(file: Path, text: str) -> str:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return str(file)


def lazy(name: str = "Lazy", label: str = "lazy") -> str:
    return COMPLETE.format(name=name, label=label)


def test_which_names_are_files_and_modules() -> None:
    assert [is_own(n) for n in ("kettle", "a.py", "dir/a.py:B", "a.b:C")] == [False, True, True, True]


@pytest.mark.parametrize("ending", ["", ":Lazy"])
def test_a_file_and_what_lies_beside_it(folder: Path, ending: str) -> None:
    write(folder / "deep" / "helper.py", "LABEL = 'lazy_one'")
    file = write(folder / "deep" / "mine.py", "from helper import LABEL\n" + lazy().replace('"lazy"', "LABEL"))
    scenario = load_scenario(file + ending, ["goal=[a >= 1]"], physics="ideal", seed=4)
    assert (scenario.name, scenario.seed, scenario.config.goal) == ("lazy_one", 4, ["a >= 1"])


def test_a_module_below_the_working_directory(folder: Path) -> None:
    write(folder / "mine" / "scenes.py", lazy() + lazy("Other", "other"))
    (folder / "mine" / "__init__.py").touch()
    assert load_scenario("mine.scenes:Other", physics="ideal").name == "other"


def test_a_file_of_settings_and_a_scenario_that_builds_on_ours(folder: Path) -> None:
    write(folder / "lazy.yaml", "description: from a file\ngoal: [a >= 2]")
    given = '    name = "lazy"\n    config_file = __import__("pathlib").Path(__file__).with_name("lazy.yaml")\n'
    file = write(folder / "mine.py", lazy().replace('    name = "lazy"\n', given))
    assert load_scenario(file, physics="ideal").config.description == "from a file"
    ours = "from ichain_drake.systems import KettleScenario\nclass Mine(KettleScenario):\n    name = 'mine'\n"
    theirs = load_scenario(write(folder / "more.py", ours), physics="ideal")
    assert theirs.config.goal == KettleScenario(physics="ideal").config.goal
    write(folder / "lazy.yaml", "descriptoin: misspelt")
    with pytest.raises(InputError, match=r"lazy\.yaml: .*descriptoin"):
        load_scenario(file, physics="ideal")


@pytest.mark.parametrize(
    ("text", "ending", "message"),
    [
        ("x = 1", "", "mine.py: it has no class made from GraphScenario or PathScenario; name a file"),
        ("x = 1", ":x", "mine.py: it has no class x made from GraphScenario or PathScenario; name one that it has"),
        ("x = 1", ":Y", "mine.py: it has no class Y made from"),
        ("from ichain_drake.systems import Ship" + "Voyage", "", "mine.py: it has no class made from"),
        (lazy() + lazy("Other"), "", "mine.py: it has several scenarios; say which, as in .*mine.py:Lazy"),
        (lazy().replace("draw_start", "drwa_start"), "", "mine.py: Lazy lacks draw_start"),
        (lazy().replace('name = "lazy"', ""), "", "mine.py: Lazy needs a name, such as name = 'my_scenario'"),
        (lazy(label="../lazy"), "", "mine.py: Lazy needs a name"),
        ("def (", "", "mine.py: can't be imported: .*mine.py, line 1: invalid syntax"),
        ("\n\n1 / 0", "", "mine.py: can't be imported: .*mine.py, line 3: ZeroDivisionError: division by zero"),
        ("import nowhere", "", "mine.py: can't be imported: .*line 1: ModuleNotFoundError: No module named 'nowhere'"),
        ("raise SystemExit(3)", "", "mine.py: can't be imported: .*line 1: SystemExit: 3"),
    ],
)
def test_a_file_without_one_scenario_is_refused(folder: Path, text: str, ending: str, message: str) -> None:
    file = write(folder / "mine.py", text)
    with pytest.raises(InputError, match=message):
        own_scenario(file + ending)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nothing.py", "nothing.py: there is no such file"),
        ("my-scenario.py", "a file that is imported has letters, digits and _ in its name; rename it"),
        ("json.py", "json.py: another module is called json; rename the file"),
        ("nowhere.at.all:Kind", "nowhere.at.all: can't be imported: ModuleNotFoundError: No module named 'nowhere'"),
        ("a b:Kind", "'a b' is no module; name your scenario as file.py, file.py:Class or package.module:Class"),
        ("json:JSONEncoder", "json: it has no class JSONEncoder made from"),
    ],
)
def test_a_name_that_leads_nowhere_is_refused_in_one_line(
    folder: Path, capfd: pytest.CaptureFixture[str], name: str, message: str
) -> None:
    for file in ("my-scenario.py", "json.py"):
        write(folder / file, "")
    assert main(["graph", name]) == 2
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert message in said
