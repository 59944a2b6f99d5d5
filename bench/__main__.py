"""All benchmarks, one after the other."""

from bench import solve_size, solve_start

for report in (solve_start.report, solve_size.report):
    for line in report():
        print(line, flush=True)
