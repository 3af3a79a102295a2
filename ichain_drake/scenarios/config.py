"""What a scenario's YAML file may say: typed sections that every scenario has, and how `--set` changes them."""

import difflib
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from ichain_drake.control.tracking.chain import METHODS, ControlCandidates
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.errors import InputError
from ichain_drake.files import read_whole
from ichain_drake.learning.chain.chain import LinkCandidates
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.robot import RobotSpec
from ichain_drake.scenarios.yaml_text import one_line, read_yaml
from ichain_drake.settings import check_settings, setting


@dataclass
class NoiseConfig:
    """Noise of the world.

    Attributes:
        scale: factor on process and measurement noise of every object.
        vehicle: factor on the declared reading noise of vehicles, on top of `scale`; 0: they are read as they are, as
            in the paper's game (sec. IV).
    """

    scale: float = setting(1.0, lower=0, upper=1000)
    vehicle: float = setting(0.0, lower=0, upper=1000)


@dataclass
class FaultConfig:
    """A disturbance that an evaluation asks for.

    Attributes:
        kind: `none`, `slip`, `knock`, `stiff`, `dropout` or `moved`; a scenario refuses those that it does not have.
    """

    kind: str = "none"


@dataclass
class CameraConfig:
    """Where the camera looks from.

    Attributes:
        yaw_deg: turn of the camera's frame against the robot's [deg].
    """

    yaw_deg: float = setting(0.0, "deg", lower=-360, upper=360)


@dataclass
class LinkConfig:
    """Candidates for learning one interaction; see `LinkCandidates`.

    Attributes:
        interaction: `parent->child`.
        forward, inverse: estimators, as `name(parameter=value, ...)`.
        features: kinds of features that are tried.
        forward_actions: which of the parent's states forward models may have as their action.
        aims: how many ticks ahead inverse models may aim.
        screening: an estimator, or empty for none; see `LinkCandidates`.
    """

    interaction: str = ""
    forward: list[str] = field(default_factory=lambda: ["polynomial(degree=2)"])
    inverse: list[str] = field(default_factory=lambda: ["polynomial(degree=2)", "polynomial(degree=3)"])
    features: list[str] = setting(lambda: ["none", "raw", "body"], choices=("none", "raw", "body"))
    forward_actions: list[str] = setting(lambda: ["next", "both"], choices=("next", "current", "both"))
    aims: list[int] = setting(lambda: [1], "ticks", lower=1, upper=100, filled=True)
    screening: str = ""


@dataclass
class LearningConfig:
    """How links are learned.

    Attributes:
        estimator: if given, the only candidate for every model.
        samples: transitions recorded and used for each link.
        action: which state of the parent is the action: `next` (paper sec. III) or `current`.
        links: candidates per interaction.
    """

    estimator: str = ""
    samples: int = setting(500, lower=1, upper=10**6)
    action: str = setting("next", choices=("next", "current"))
    links: list[LinkConfig] = field(default_factory=list)

    def candidates(self) -> dict[str, LinkCandidates]:
        """Candidates per interaction name.

        Raises:
            InputError: on a bad estimator, or a value that its setting does not allow.
        """
        check_settings(self, where="learning")
        return {link.interaction: self._link(link) for link in self.links}

    def _link(self, link: LinkConfig) -> LinkCandidates:
        estimators = [self.estimator] if self.estimator else None
        return LinkCandidates(
            tuple(EstimatorSpec.parse(t) for t in estimators or link.forward),
            tuple(EstimatorSpec.parse(t) for t in estimators or link.inverse),
            tuple(link.features),  # type: ignore[arg-type]
            tuple(link.forward_actions),  # type: ignore[arg-type]
            tuple(link.aims),
            EstimatorSpec.parse(link.screening) if link.screening else None,
            self.action,  # type: ignore[arg-type]
            self.samples,
        )


@dataclass
class ControlConfig:
    """How the chain is controlled; see `ControlCandidates`.

    Attributes:
        method: `predictive` or `inverse` (the paper's).
        horizons, efforts, along: what validation may choose from.
        offset: weight of the newest error of the last object's model in the estimate of its lasting error, which
            predictive control reckons with; 0: it takes the model at its word. See `OffsetEstimate`.
    """

    method: str = setting("predictive", choices=METHODS)
    horizons: list[int] = setting(lambda: [5], "ticks", lower=2, upper=60, filled=True)
    efforts: list[float] = setting(lambda: [0.02, 0.05, 0.1], above=0, upper=1e4, filled=True)
    along: float = setting(0.2, lower=0, upper=1e4)
    offset: float = setting(0.0, lower=0, below=1)

    def candidates(self) -> ControlCandidates:
        """What validation may choose from.

        Raises:
            InputError: on a value that its setting does not allow.
        """
        check_settings(self, where="control")
        return ControlCandidates(tuple(self.horizons), tuple(self.efforts), self.along, self.offset)


@dataclass
class PathConfig:
    """How paths are followed; see `PathLimits`.

    Attributes:
        speed: nominal speed.
        turn_rate: speed is lowered where the path's curvature would need a higher one.
        spacing: of the sampled path.
        smoothing: length over which curvature is averaged.
        tolerance: the end counts as reached within this distance of it.
        corridor: a point of the path counts as passed within this distance of it; a run that has not passed all of them
            has not followed the path.
    """

    speed: float = setting(45.0, "{unit}/s", above=0, upper=1e4)
    turn_rate: float = setting(1.1, "rad/s", above=0, upper=100)
    spacing: float = setting(1.0, "{unit}", above=0, upper=1e4)
    smoothing: float = setting(40.0, "{unit}", above=0, upper=1e5)
    tolerance: float = setting(3.0, "{unit}", above=0, upper=1e4)
    corridor: float = setting(10.0, "{unit}", above=0, upper=1e4)

    def limits(self) -> PathLimits:
        """The same as `PathLimits`.

        Raises:
            InputError: on a value that its setting does not allow.
        """
        check_settings(self, where="path")
        return PathLimits(self.speed, self.turn_rate, self.spacing, self.smoothing, self.tolerance, self.corridor)


@dataclass
class ScenarioConfig:
    """Sections that every scenario's file has.

    Attributes:
        description: one line for `ichain list`.
        robot: see `RobotSpec`.
        noise, fault, camera, learning, control: see there.
    """

    description: str = ""
    robot: RobotSpec = field(default_factory=RobotSpec)
    noise: NoiseConfig = field(default_factory=NoiseConfig)
    fault: FaultConfig = field(default_factory=FaultConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)
    learning: LearningConfig = field(default_factory=LearningConfig)
    control: ControlConfig = field(default_factory=ControlConfig)


ConfigT = TypeVar("ConfigT", bound=ScenarioConfig)


def load_config(schema: type[ConfigT], file: Path | None, overrides: str | Sequence[str] = ()) -> ConfigT:
    """Read a scenario's YAML file.

    Args:
        schema: the scenario's configuration class.
        file: the YAML file; None for the defaults of `schema`.
        overrides: `key.key=value` settings, values in YAML; one, or several in order.

    Raises:
        InputError: on a file that can't be read, malformed YAML, or an unknown key, with close ones.
    """
    try:
        text = "" if file is None else read_whole(file, "the scenario").decode()
    except UnicodeDecodeError as error:
        raise InputError(f"{file}: can't read the scenario: {one_line(error)}") from None
    given = (overrides,) if isinstance(overrides, str) else tuple(overrides)
    found: ConfigT = deepcopy(_loaded(schema, text, str(file or schema.__name__), given))  # type: ignore[arg-type]
    return found


@lru_cache(maxsize=64)  # an evaluation makes its scenarios again and again; the file's text is part of the key
def _loaded(schema: type[ConfigT], text: str, where: str, overrides: tuple[str, ...]) -> ConfigT:
    data = read_yaml(text, where) or {}
    if not isinstance(data, dict):
        raise InputError(f"{where}: a scenario is a mapping of sections")
    config = _typed(schema, data, where)
    for setting_text in overrides:
        default = _override(data, setting_text, schema)
        config = _typed(schema, data, f"--set {setting_text}", default)
    return config


def _typed(schema: type[ConfigT], data: dict[str, Any], where: str, default: Any = None) -> ConfigT:
    try:
        return yaml_load_typed(schema=schema, data=yaml.safe_dump(data), defaults=schema())
    except Exception as error:  # pydrake raises several kinds for bad values
        raise InputError(f"{where}: {_explain(error, default)}") from None


_FORMS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text", list: "a list, as [a, b]",
          tuple: "a list, as [a, b]", dict: "a mapping, as {a: 1}"}  # fmt: skip
"""How a value of a type is written."""


def _explain(error: Exception, default: Any) -> str:
    """Drake's error without addresses of YAML strings that the user never wrote; what belongs there, by its default."""
    if isinstance(error, AssertionError):
        return f"a section of keys belongs there, not {one_line(error) or 'a plain value'}"
    text = one_line(error).replace("<string>", "").strip(": ")[:400]
    form = _FORMS.get(type(default), "")
    if isinstance(default, list | tuple) and default:
        form = f"a list, such as {list(default)}"[:80]
    return f"{form} is needed there ({text})" if form else text


def _override(data: dict[str, Any], text_of: str, schema: type[Any]) -> Any:
    """Put a setting into plain data; gives the default that it replaces, None where there is none."""
    key, sign, text = text_of.partition("=")
    if not sign or not key.strip():
        raise InputError(f"--set {text_of[:80]!r}: write key=value, such as noise.scale=2")
    value = read_yaml(text, f"--set {key}")
    parts = [p.strip() for p in key.split(".")]
    node, kind = data, schema()
    for i, part in enumerate(parts):
        names = [f.name for f in fields(kind)] if is_dataclass(kind) else list(kind) if isinstance(kind, dict) else []
        free = isinstance(kind, dict) or kind is None  # an optional section, absent by default
        if not free and part not in names:
            close = difflib.get_close_matches(part, names, n=1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(names) or 'none'}"
            raise InputError(f"--set {key}: there is no key {part!r}; {hint}")
        if i == len(parts) - 1:
            node[part] = value
            return None if free else getattr(kind, part)
        kind = (kind or {}).get(part, {}) if free else getattr(kind, part)
        if not isinstance(node.get(part), dict):
            node[part] = {}
        node = node[part]
    return None


def as_plain(value: Any) -> Any:
    """A configuration as dictionaries, lists and numbers, for a report."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: as_plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, dict):
        return {str(k): as_plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [as_plain(v) for v in value]
    if isinstance(value, str | int | float | bool) or value is None:
        return value
    return str(value)
