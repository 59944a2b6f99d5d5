"""All benchmarks, one after the other."""

from bench import points, refine, sets, solve_size, solve_start

for report in (solve_start.report, solve_size.report, refine.report, points.report, sets.report):
    for line in report():
        print(line, flush=True)
