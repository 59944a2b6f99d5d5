// Uniform refinement of a closed mesh by OpenSubdiv, timed: refine FILE OUT DEPTH RUNS
//
// FILE holds the numbers of vertices and of faces (int64), the vertices (3 doubles each), then each face: its
// size and its vertices (int64). OUT receives the limit positions of the vertices of the last level (3 doubles
// each), then its faces (4 int64 each). Standard output: a line a run, milliseconds for the refinement of the
// topology, the interpolation of all levels, the limit positions and the copy of the faces into one array;
// then a line with the numbers of vertices and faces. All on one thread.

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <vector>

using namespace OpenSubdiv;

struct Point {
    double x, y, z;
    void Clear() { x = y = z = 0; }
    void AddWithWeight(Point const& other, double weight) {
        x += weight * other.x;
        y += weight * other.y;
        z += weight * other.z;
    }
};

static double now() {
    using namespace std::chrono;
    return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

static std::vector<int64_t> whole_numbers(std::ifstream& file, size_t count) {
    std::vector<int64_t> found(count);
    file.read(reinterpret_cast<char*>(found.data()), count * sizeof(int64_t));
    return found;
}

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: refine FILE OUT DEPTH RUNS\n");
        return 2;
    }
    std::ifstream file(argv[1], std::ios::binary);
    int const depth = std::atoi(argv[3]), runs = std::atoi(argv[4]);
    auto const counts = whole_numbers(file, 2);
    std::vector<Point> control(counts[0]);
    file.read(reinterpret_cast<char*>(control.data()), control.size() * sizeof(Point));
    std::vector<int> sizes, corners;
    for (int64_t face = 0; face < counts[1]; ++face) {
        sizes.push_back(int(whole_numbers(file, 1)[0]));
        for (int64_t vertex : whole_numbers(file, sizes.back())) corners.push_back(int(vertex));
    }
    if (!file) {
        std::fprintf(stderr, "the file is too short\n");
        return 2;
    }
    Far::TopologyDescriptor description;
    description.numVertices = int(control.size());
    description.numFaces = int(sizes.size());
    description.numVertsPerFace = sizes.data();
    description.vertIndicesPerFace = corners.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;

    std::vector<Point> limits;
    std::vector<int64_t> faces;
    for (int run = 0; run < runs; ++run) {
        limits = {};
        faces = {};
        double const start = now();
        std::unique_ptr<Far::TopologyRefiner> refiner(
            Factory::Create(description, Factory::Options(Sdc::SCHEME_CATMARK, Sdc::Options())));
        Far::TopologyRefiner::UniformOptions options(depth);
        options.fullTopologyInLastLevel = true;  // limit positions need it
        refiner->RefineUniform(options);
        double const refined = now();

        Far::PrimvarRefinerReal<double> interpolation(*refiner);
        std::vector<Point> level = control;
        for (int i = 1; i <= depth; ++i) {
            std::vector<Point> finer(refiner->GetLevel(i).GetNumVertices());
            interpolation.Interpolate(i, level, finer);
            level.swap(finer);
        }
        double const interpolated = now();
        limits.resize(level.size());
        interpolation.Limit(level, limits);
        double const limited = now();
        Far::TopologyLevel const& last = refiner->GetLevel(depth);
        faces.reserve(4 * size_t(last.GetNumFaces()));
        for (int face = 0; face < last.GetNumFaces(); ++face) {
            Far::ConstIndexArray const found = last.GetFaceVertices(face);
            faces.insert(faces.end(), found.begin(), found.end());
        }
        double const copied = now();
        std::printf("%.3f %.3f %.3f %.3f\n", refined - start, interpolated - refined, limited - interpolated,
                    copied - limited);
    }
    std::printf("%zu %zu\n", limits.size(), faces.size() / 4);
    std::ofstream out(argv[2], std::ios::binary);
    out.write(reinterpret_cast<char const*>(limits.data()), limits.size() * sizeof(Point));
    out.write(reinterpret_cast<char const*>(faces.data()), faces.size() * sizeof(int64_t));
    return out ? 0 : 1;
}
