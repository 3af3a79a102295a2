"""Looking at runs: recordings, playback in the browser, pictures. Reads logs only; nothing here is simulated."""

from ichain_drake.visualization.calibration_plots import plot_coverage, plot_reliability
from ichain_drake.visualization.controls import Axis, Controls, PageButton
from ichain_drake.visualization.game_screen import GameScreen
from ichain_drake.visualization.hand_drawing import HandDrawing
from ichain_drake.visualization.live import LiveView
from ichain_drake.visualization.playback import Camera, write_playback
from ichain_drake.visualization.plots import plot_learning_curve, plot_paths, plot_success_curve
from ichain_drake.visualization.recording import Readout, RecordedEpisode, Recording, Strip
from ichain_drake.visualization.recording_file import load_recording, save_recording
from ichain_drake.visualization.scene import Drawing, EpisodeDrawing, Scene, linear_rgb
from ichain_drake.visualization.timeline import Lane, plot_timeline

__all__ = [
    "Axis",
    "PageButton",
    "Camera",
    "Controls",
    "Drawing",
    "RecordedEpisode",
    "EpisodeDrawing",
    "GameScreen",
    "HandDrawing",
    "Lane",
    "LiveView",
    "Readout",
    "Recording",
    "Scene",
    "Strip",
    "linear_rgb",
    "load_recording",
    "plot_coverage",
    "plot_learning_curve",
    "plot_paths",
    "plot_reliability",
    "plot_success_curve",
    "plot_timeline",
    "save_recording",
    "write_playback",
]
