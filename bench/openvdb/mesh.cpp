// Time and memory of OpenVDB's mesher on a set of voxels, as JSON: mesh FOLDER, which holds set.vdb
//
// The set becomes a grid of Booleans, true in its voxels. Memory is the largest resident size, less what the
// process had before it read the set. On one thread; the least of up to three runs.

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

// A line of /proc/self/status, in bytes.
double status(const std::string& name)
{
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);)
        if (line.rfind(name + ":", 0) == 0)
            return 1024 * std::stod(line.substr(name.size() + 1));
    return 0;
}

openvdb::BoolGrid::Ptr read(const std::string& path)
{
    openvdb::io::File file(path);
    file.open();
    const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>((*file.getGrids())[0]);
    const auto tree = std::make_shared<openvdb::BoolTree>(floats->tree(), false, true, openvdb::TopologyCopy());
    return openvdb::BoolGrid::create(tree);
}

int main(int count, char** words)
{
    if (count != 2) {
        std::fprintf(stderr, "usage: mesh FOLDER\n");
        return 2;
    }
    tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    openvdb::initialize();
    const double held = status("VmRSS");
    const auto grid = read(std::string(words[1]) + "/set.vdb");
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";

    std::size_t triangles = 0;
    double best = 1e9, all = 0;
    for (int run = 0; run < 3 && all < 20; ++run) {
        std::vector<openvdb::Vec3s> points;
        std::vector<openvdb::Vec4I> quads;
        const auto start = std::chrono::steady_clock::now();
        openvdb::tools::volumeToMesh(*grid, points, quads, 0.5);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        best = std::min(best, seconds);
        all += seconds;
        triangles = 2 * quads.size();
    }
    std::printf("{\"time\": %g, \"memory\": %.0f, \"says\": \"%zu triangles, as squares\"}\n", best,
        status("VmHWM") - held, triangles);
    return 0;
}
