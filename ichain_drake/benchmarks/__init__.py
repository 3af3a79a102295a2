"""What the library costs: every figure that `ichain benchmarks` prints."""

from ichain_drake.benchmarks.run import BenchmarkSizes, run_benchmarks
from ichain_drake.benchmarks.table import format_table

__all__ = ["BenchmarkSizes", "format_table", "run_benchmarks"]
