"""Looking at runs: recordings, playback in the browser, pictures. Reads logs only; nothing here is simulated."""

from ichain_drake.visualization.game_screen import GameScreen
from ichain_drake.visualization.hand_drawing import HandDrawing
from ichain_drake.visualization.playback import Camera, write_playback
from ichain_drake.visualization.plots import plot_learning_curve, plot_paths
from ichain_drake.visualization.recording import Episode, Readout, Recording
from ichain_drake.visualization.recording_file import load_recording, save_recording
from ichain_drake.visualization.scene import Drawing, EpisodeDrawing, Scene, linear_rgb

__all__ = [
    "Camera",
    "Drawing",
    "Episode",
    "EpisodeDrawing",
    "GameScreen",
    "HandDrawing",
    "Readout",
    "Recording",
    "Scene",
    "linear_rgb",
    "load_recording",
    "plot_learning_curve",
    "plot_paths",
    "save_recording",
    "write_playback",
]
