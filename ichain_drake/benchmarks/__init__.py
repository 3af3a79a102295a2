"""What the library costs: every figure that `ichain benchmarks` prints."""

from ichain_drake.benchmarks.phases import profile_run
from ichain_drake.benchmarks.run import BenchmarkSizes, run_benchmarks
from ichain_drake.benchmarks.scaling import ScalingSizes, format_scaling, run_scaling
from ichain_drake.benchmarks.table import format_profile, format_table

__all__ = [
    "BenchmarkSizes",
    "ScalingSizes",
    "format_profile",
    "format_scaling",
    "format_table",
    "profile_run",
    "run_benchmarks",
    "run_scaling",
]
