"""The screen of a two-dimensional game in the scene: playfield, sprite, commanded path and the path driven so far."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from pydrake.geometry import Box, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.errors import InputError
from ichain_drake.visualization.scene import Scene
from ichain_drake.visualization.sprites import car_sprite, playfield

FloatArray = NDArray[np.float64]

COMMANDED = Rgba(0.93, 0.95, 0.97)
EXECUTED = Rgba(1.0, 0.5, 0.0)

# Heights above the panel [m], far enough apart for any depth buffer.
_COMMANDED, _EXECUTED, _GHOST, _SPRITE = 0.001, 0.002, 0.003, 0.004
_LEAST_TRAIL = 1.0  # px
_COMMANDED_WIDTH, _EXECUTED_WIDTH = 0.004, 0.0025  # of the two paths [m]
_FRAME, _DEPTH = 0.014, 0.022  # bezel's width and thickness [m]


class GameScreen:
    """Draws an object that moves on a plane, such as the car of a game; a `Drawing`.

    The screen's frame S: origin at the middle of the panel, x right, y up, z toward the viewer.

    Args:
        size: width and height of the screen [px].
        metres_per_pixel: size of a pixel in the scene [m].
        X_WS: pose of the screen in the world.
        columns: where x, y [px] and heading [rad] are in the object's state; without a heading it stays upright.
        y_down: whether the game's y points down (then a positive heading turns clockwise).
        sprite: picture of the object, pointing to +x at heading 0; a car by default.
        sprite_length: its extent along x [px].
        field: picture of the playfield, as wide and high as the screen; a grid by default.
        corner: lowest x and y on the screen, where it shows a part of a larger plane [px].
        ghost_period: a faded copy of the sprite stays behind every so often [s]; 0 for none.
        stand: height of the screen's lower edge over the ground, bridged by two legs [m]; 0 for none.

    Raises:
        InputError: if the size, scale or columns make no screen.
    """

    def __init__(
        self,
        size: tuple[int, int],
        metres_per_pixel: float,
        X_WS: RigidTransform,
        *,
        columns: Sequence[int] = (0, 1, 2),
        y_down: bool = True,
        sprite: Image.Image | None = None,
        sprite_length: float = 44.0,
        field: Image.Image | None = None,
        corner: tuple[float, float] = (0.0, 0.0),
        ghost_period: float = 0.0,
        stand: float = 0.0,
    ) -> None:
        if min(*size, metres_per_pixel, sprite_length) <= 0:
            raise InputError("game screen: size, metres_per_pixel and sprite_length must be positive")
        if len(columns) not in {2, 3}:
            raise InputError(f"game screen: columns are x, y and, if there is one, heading; {len(columns)} given")
        self.legend = (("commanded path", COMMANDED), ("executed path", EXECUTED))
        self._size = size
        self._scale = metres_per_pixel
        self._X_WS = X_WS
        self._columns = list(columns)
        self._flip = -1.0 if y_down else 1.0
        self._sprite = sprite if sprite is not None else car_sprite()
        self._sprite_length = sprite_length
        self._field = field
        self._middle = np.array(corner) + np.array(size) / 2
        self._ghost_period = ghost_period
        self._stand = stand
        self._episodes = 0
        self._trails = 0

    def setup(self, scene: Scene) -> None:
        """Create panel and sprite."""
        width, height = (n * self._scale for n in self._size)
        dark = Rgba(0.13, 0.14, 0.16)
        case = Box(width + 2 * _FRAME, height + 2 * _FRAME, _DEPTH)
        scene.shape("screen/case", case, dark, _at(z=-_DEPTH / 2 - 0.001))
        for side in (-1, 1) if self._stand > 0 else ():
            leg = _at(x=side * width * 0.3, y=-(height + self._stand) / 2 - _FRAME / 2, z=-_DEPTH / 2 - 0.001)
            scene.shape(f"screen/leg{side}", Box(0.024, self._stand - _FRAME, 0.014), dark, leg)
        field = self._field if self._field is not None else playfield(*self._size, y_down=self._flip < 0)
        scene.image("screen/field", field, width, height)
        self._put_sprite(scene, "screen/sprite", self._sprite)
        scene.place("screen", self._X_WS)

    def begin_episode(self, scene: Scene, times: FloatArray, states: FloatArray, line: FloatArray | None) -> None:
        """Create the paths of an episode, shown from its start to the start of the next one."""
        now = f"screen/episode{self._episodes}"
        if self._episodes:
            scene.visible(f"screen/episode{self._episodes - 1}", False, times[0])
            scene.visible(now, False, 0.0)
        scene.visible(now, True, times[0])
        self._episodes += 1
        self._trails = 0
        if line is not None and len(line) > 1:
            scene.line(f"{now}/commanded", self.points(line, _COMMANDED), _COMMANDED_WIDTH, COMMANDED)
        driven = self.points(states[:, self._columns[:2]], _EXECUTED)
        scene.growing_line(f"{now}/executed", driven, times, _EXECUTED_WIDTH, EXECUTED)
        if self._ghost_period > 0:
            faded = self._sprite.copy()
            faded.putalpha(faded.getchannel("A").point(lambda a: a * 0.35))
            step = max(1, round(self._ghost_period / max(times[-1] - times[0], 1e-9) * (len(times) - 1)))
            for k in range(0, len(times), step):
                ghost = f"{now}/ghost{k}"
                self._put_sprite(scene, ghost, faded)
                scene.place(ghost, self.sprite_pose(states[k], _GHOST))
                scene.visible(ghost, False, 0.0)
                scene.visible(ghost, True, times[min(k + 1, len(times) - 1)])

    def extend_trail(self, scene: Scene, states: FloatArray) -> None:
        """Add to the path driven so far, in a scene in which the rest of it is not known yet.

        Args:
            scene: where the parts are.
            states: the last states, shape (n, n_variables), from the one that the path reached before.
        """
        if np.ptp(states[:, self._columns[:2]], axis=0).max() < _LEAST_TRAIL:
            return
        path = f"screen/episode{max(self._episodes - 1, 0)}/trail{self._trails}"
        scene.line(path, self.points(states[:, self._columns[:2]], _EXECUTED), _EXECUTED_WIDTH, EXECUTED)
        self._trails += 1

    def update(self, scene: Scene, time: float, state: FloatArray) -> None:
        """Move the sprite to a state [px, px, rad]."""
        scene.pose("screen/sprite", self.sprite_pose(state), time)

    def points(self, positions: ArrayLike, height: float = 0.0) -> FloatArray:
        """Points in the screen's frame.

        Args:
            positions: on the game's screen, shape (n, 2) [px].
            height: above the panel [m].

        Returns:
            shape (n, 3) [m].
        """
        p = (np.asarray(positions, dtype=float) - self._middle) * self._scale * [1.0, self._flip]
        return np.column_stack([p, np.full(len(p), height)])

    def sprite_pose(self, state: FloatArray, height: float = _SPRITE) -> RigidTransform:
        """Pose of the sprite in the screen's frame at a state of the object."""
        heading = self._flip * float(state[self._columns[2]]) if len(self._columns) > 2 else 0.0
        position = self.points(state[None, self._columns[:2]], height)[0]
        return RigidTransform(RotationMatrix.MakeZRotation(heading), position)

    def _put_sprite(self, scene: Scene, path: str, picture: Image.Image) -> None:
        length = self._sprite_length * self._scale
        scene.image(path, picture, length, length * picture.height / picture.width)


def _at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> RigidTransform:
    return RigidTransform([x, y, z])
