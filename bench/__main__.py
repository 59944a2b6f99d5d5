"""All benchmarks, one after the other."""

from bench import solve_start

for line in solve_start.report():
    print(line, flush=True)
