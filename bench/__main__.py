"""All benchmarks, one after the other."""

from bench import parts, points, refine, sets, solve_size, solve_start, voxels

for part in (solve_start, solve_size, refine, points, sets, voxels, parts):
    for line in part.report():
        print(line, flush=True)
