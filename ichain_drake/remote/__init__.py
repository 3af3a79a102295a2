"""A robot in another process: its world and the hand commands as LCM messages, so that one controller drives either."""

from ichain_drake.remote.lossy import Lossy
from ichain_drake.remote.robot import RobotServer
from ichain_drake.remote.world import RemoteWorld, connect

__all__ = ["Lossy", "RemoteWorld", "RobotServer", "connect"]
