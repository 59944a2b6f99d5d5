// Times of OpenVDB on two sets of voxels, as JSON: sets A.vdb B.vdb RADIUS
//
// Boolean operations work in place there, so a copy is timed as well. Masks dilate by steps of neighbours;
// the ball goes through a level set. All on one thread.

#include <openvdb/openvdb.h>
#include <openvdb/tools/Morphology.h>
#include <openvdb/tools/TopologyToLevelSet.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

using Mask = openvdb::MaskTree;

template <typename Action>
double least(int runs, Action action)
{
    double best = 1e9;
    for (int run = 0; run < runs; ++run)
        best = std::min(best, action());
    return best;
}

template <typename Action>
double seconds(Action action)
{
    const auto start = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Mask read(const std::string& path)
{
    openvdb::io::File file(path);
    file.open();
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>((*file.getGrids())[0]);
    if (!grid) {
        std::fprintf(stderr, "%s holds no grid of floats\n", path.c_str());
        std::exit(1);
    }
    return Mask(grid->tree(), false, true, openvdb::TopologyCopy());
}

int main(int count, char** words)
{
    if (count != 4) {
        std::fprintf(stderr, "usage: sets A.vdb B.vdb RADIUS\n");
        return 2;
    }
    tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    openvdb::initialize();
    const Mask a = read(words[1]), b = read(words[2]);
    const int radius = std::atoi(words[3]);

    const double copy = least(3, [&] { return seconds([&] { Mask c(a); }); });
    const double either = least(3, [&] { Mask c(a); return seconds([&] { c.topologyUnion(b); }); });
    const double both = least(3, [&] { Mask c(a); return seconds([&] { c.topologyIntersection(b); }); });
    const double minus = least(3, [&] { Mask c(a); return seconds([&] { c.topologyDifference(b); }); });
    const double faces = least(1, [&] {
        Mask c(a);
        return seconds([&] { openvdb::tools::dilateActiveValues(c, radius, openvdb::tools::NN_FACE); });
    });
    // The way through a level set takes minutes where there are many leaves.
    const double ball = a.leafCount() > 40000 ? -1 : least(1, [&] {
        openvdb::MaskGrid grid(openvdb::MaskTree::Ptr(new Mask(a)));
        return seconds([&] { openvdb::tools::topologyToLevelSet(grid, 3, 0, radius, 0); });
    });
    std::printf("{\"bytes\": %llu, \"voxels\": %llu, \"copy\": %g, \"or\": %g, \"and\": %g, \"minus\": %g, "
                "\"dilate by faces\": %g, \"dilate by a ball\": %g}\n",
        static_cast<unsigned long long>(a.memUsage()), static_cast<unsigned long long>(a.activeVoxelCount()), copy,
        either, both, minus, faces, ball);
    return 0;
}
