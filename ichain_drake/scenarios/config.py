"""What a scenario's YAML file may say: typed sections that every scenario has, and how `--set` changes them."""

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from ichain_drake.control.tracking.chain import METHODS, ControlCandidates
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LinkCandidates
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.robot import RobotSpec


@dataclass
class NoiseConfig:
    """Noise of the world.

    Attributes:
        scale: factor on process and measurement noise of every object.
        vehicle: factor on the declared reading noise of vehicles, on top of `scale`; 0: they are read as they are, as
            in the paper's game (sec. IV).
    """

    scale: float = 1.0
    vehicle: float = 0.0


@dataclass
class FaultConfig:
    """A disturbance that an evaluation asks for.

    Attributes:
        kind: `none`, `slip`, `knock`, `stiff` or `dropout`; a scenario refuses those that it does not have.
    """

    kind: str = "none"


@dataclass
class CameraConfig:
    """Where the camera looks from.

    Attributes:
        yaw_deg: turn of the camera's frame against the robot's [deg].
    """

    yaw_deg: float = 0.0


@dataclass
class LinkConfig:
    """Candidates for learning one interaction; see `LinkCandidates`.

    Attributes:
        interaction: `parent->child`.
        forward, inverse: estimators, as `name(parameter=value, ...)`.
        features, forward_actions, aims: see `LinkCandidates`.
        screening: an estimator, or empty for none; see `LinkCandidates`.
    """

    interaction: str = ""
    forward: list[str] = field(default_factory=lambda: ["polynomial(degree=2)"])
    inverse: list[str] = field(default_factory=lambda: ["polynomial(degree=2)", "polynomial(degree=3)"])
    features: list[str] = field(default_factory=lambda: ["none", "raw", "body"])
    forward_actions: list[str] = field(default_factory=lambda: ["next", "both"])
    aims: list[int] = field(default_factory=lambda: [1])
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
    samples: int = 500
    action: str = "next"
    links: list[LinkConfig] = field(default_factory=list)

    def candidates(self) -> dict[str, LinkCandidates]:
        """Candidates per interaction name.

        Raises:
            InputError: on a bad estimator, feature kind, action or aim; names the interaction.
        """
        if self.samples < 1:
            raise InputError(f"learning.samples is {self.samples}; give at least 1")
        if self.action not in ("next", "current"):
            raise InputError(f"learning.action {self.action!r}: choose next or current")
        return {link.interaction: self._link(link) for link in self.links}

    def _link(self, link: LinkConfig) -> LinkCandidates:
        where = f"learning of {link.interaction}"
        for given, known, what in (
            (link.features, ("none", "raw", "body"), "features"),
            (link.forward_actions, ("next", "current", "both"), "forward_actions"),
        ):
            for item in given:
                if item not in known:
                    raise InputError(f"{where}: {what} {item!r}: choose from {', '.join(known)}")
        if not link.aims or min(link.aims) < 1:
            raise InputError(f"{where}: aims {link.aims}: give whole numbers from 1")
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

    method: str = "predictive"
    horizons: list[int] = field(default_factory=lambda: [5])
    efforts: list[float] = field(default_factory=lambda: [0.02, 0.05, 0.1])
    along: float = 0.2
    offset: float = 0.0

    def candidates(self) -> ControlCandidates:
        """What validation may choose from.

        Raises:
            InputError: on an unknown method, an empty list or a horizon below 2.
        """
        if self.method not in METHODS:
            raise InputError(f"control.method {self.method!r}: choose {' or '.join(METHODS)}")
        if not self.horizons or not self.efforts or min(self.horizons) < 2 or min(self.efforts) <= 0:
            raise InputError("control: give horizons of at least 2 ticks and efforts above 0")
        if not 0.0 <= self.offset < 1.0:
            raise InputError(f"control.offset is {self.offset}; give a weight from 0 to below 1")
        return ControlCandidates(tuple(self.horizons), tuple(self.efforts), self.along, self.offset)


@dataclass
class PathConfig:
    """How paths are followed; see `PathLimits`."""

    speed: float = 45.0
    turn_rate: float = 1.1
    spacing: float = 1.0
    smoothing: float = 40.0
    tolerance: float = 3.0

    def limits(self) -> PathLimits:
        """The same as `PathLimits`.

        Raises:
            InputError: if one is not above 0.
        """
        for item in fields(self):
            if not getattr(self, item.name) > 0:
                raise InputError(f"path.{item.name} is {getattr(self, item.name)}; give a number above 0")
        return PathLimits(self.speed, self.turn_rate, self.spacing, self.smoothing, self.tolerance)


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


def load_config(schema: type[ConfigT], file: Path | None, overrides: Sequence[str] = ()) -> ConfigT:
    """Read a scenario's YAML file.

    Args:
        schema: the scenario's configuration class.
        file: the YAML file; None for the defaults of `schema`.
        overrides: `key.key=value` settings, values in YAML.

    Raises:
        InputError: on a file that can't be read, malformed YAML, or an unknown key, with close ones.
    """
    try:
        data = {} if file is None else yaml.safe_load(file.read_text()) or {}
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: can't read the scenario: {_one_line(error)}") from None
    except yaml.YAMLError as error:
        raise InputError(f"{file}: malformed YAML: {_one_line(error)}") from None
    if not isinstance(data, dict):
        raise InputError(f"{file}: a scenario is a mapping of sections")
    config = _typed(schema, data, str(file or schema.__name__))
    for setting in overrides:
        _override(data, setting, schema)
        config = _typed(schema, data, f"--set {setting}")
    return config


def _typed(schema: type[ConfigT], data: dict[str, Any], where: str) -> ConfigT:
    try:
        return yaml_load_typed(schema=schema, data=yaml.safe_dump(data), defaults=schema())
    except Exception as error:  # pydrake raises several kinds for bad values
        raise InputError(f"{where}: {_explain(error)}") from None


def _one_line(error: Exception) -> str:
    return re.sub(r"\s+", " ", str(error)).strip()


def _explain(error: Exception) -> str:
    """Drake's error without addresses of YAML strings that the user never wrote."""
    if isinstance(error, AssertionError):
        return f"a section of keys belongs there, not {_one_line(error) or 'a plain value'}"
    return _one_line(error).replace("<string>", "").strip(": ")[:400]


def _override(data: dict[str, Any], setting: str, schema: type[Any]) -> None:
    key, sign, text = setting.partition("=")
    if not sign or not key.strip():
        raise InputError(f"--set {setting!r}: write key=value, such as noise.scale=2")
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise InputError(f"--set {setting!r}: malformed value: {_one_line(error)}") from None
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
            return
        kind = (kind or {}).get(part, {}) if free else getattr(kind, part)
        if not isinstance(node.get(part), dict):
            node[part] = {}
        node = node[part]


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
