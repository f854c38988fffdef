#include <cmath>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/geometry_surface.hpp"

namespace oncollide {
namespace {

/// A geometry's tree in its own backend, expanded and collapsed explicitly.
class Grown {
public:
    Grown(const Geometry& geometry, int depth, std::unique_ptr<OcclusionBackend> backend)
        : root_(root_cell_of(geometry)), depth_(depth), tree_(root_, depth, 0), backend_(std::move(backend))
    {
        backend_->attach(0, make_surface(geometry, root_));
    }

    /// Expands these cells in one batch.
    void expand(const std::vector<CellKey>& cells, std::uint32_t frame)
    {
        std::vector<OctantRow> rows;
        for (CellKey cell : cells) rows.push_back(tree_.row(0, cell));
        answers_.resize(rows.size());
        work_ = backend_->run(rows, 1, answers_);
        repeats_ += work_.repeats, gpu_bytes_ += work_.bytes;
        for (std::size_t i = 0; i < rows.size(); ++i) tree_.expand(cells[i], answers_[i], frame);
    }

    /// Grows level by level, returning every cell's mask.
    std::vector<std::uint8_t> grow_whole()
    {
        std::vector<std::uint8_t> masks;
        std::vector<CellKey> level{root_cell}, next;
        while (!level.empty()) {
            expand(level, 1);
            next.clear();
            for (std::size_t i = 0; i < level.size(); ++i) {
                masks.push_back(answers_[i].grey);
                for (unsigned k = 0; k < 8; ++k)
                    if (answers_[i].grey >> k & 1 && level_of(level[i]) + 1 < depth_)
                        next.push_back(child_cell(level[i], k));
            }
            level.swap(next);
        }
        return masks;
    }

    std::vector<std::uint32_t> triangles(CellKey cell)
    {
        std::vector<std::uint32_t> found;
        std::vector<std::size_t> ends;
        backend_->read(std::vector<ListRead>{{0, tree_.parent_list(cell), octant_of(cell)}}, found, ends);
        return found;
    }

    /// The cells of level 2 that the tree knows.
    std::vector<CellKey> known() const
    {
        std::vector<CellKey> cells;
        for (CellKey cell = 64; cell < 128; ++cell)
            if (tree_.knows(cell)) cells.push_back(cell);
        return cells;
    }

    Ocst& tree() { return tree_; }
    OcclusionBackend& backend() { return *backend_; }
    std::uint64_t repeats() const { return repeats_; }
    std::uint64_t gpu_bytes() const { return gpu_bytes_; }

    void touch_root(std::uint32_t frame)
    {
        OcstNode& root = tree_.nodes()[0];
        root.state = (root.state & 0x1ff) | frame << OcstNode::stamp_shift;
    }
    /// Whether a cell of level 1 is expanded.
    bool expanded(CellKey cell) const { return !children(cell).empty(); }
    std::vector<CellKey> children(CellKey cell) const
    {
        std::vector<CellKey> cells;
        for (unsigned k = 0; k < 8; ++k)
            if (tree_.knows(child_cell(cell, k))) cells.push_back(child_cell(cell, k));
        return cells;
    }

private:
    RootCell root_;
    int depth_;
    Ocst tree_;
    std::unique_ptr<OcclusionBackend> backend_;
    std::vector<OctantResult> answers_;
    BatchWork work_;
    std::uint64_t repeats_ = 0, gpu_bytes_ = 0;
};

Geometry geometry_of(Mesh mesh)
{
    return {"mesh", std::move(mesh), {}};
}

Mesh knot(int triangles)
{
    return make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, triangles);
}

/// Vertices on the faces of cells, moved by slightly less or more than the slack of the test.
Mesh almost_on_cell_faces()
{
    Mesh mesh = make_soup_mesh(400, 0.7, 1.6, 21);
    std::mt19937 random(5);
    for (Eigen::Vector3d& v : mesh.vertices)
        for (int axis = 0; axis < 3; ++axis) v[axis] = std::round(8 * v[axis]) / 8 + (int(random() % 9) - 4) * 0x1p-20;
    mesh.vertices[0] = {-1, -1, -1}, mesh.vertices[1] = {1, 1, 1}; // the root cell extends from -1 to 1
    return make_mesh("almost", mesh.vertices, mesh.triangles);
}

TEST(GlCompute, GivesTheMasksOfTheCpuBitForBit)
{
    std::vector<Geometry> geometries;
    geometries.push_back(geometry_of(almost_on_cell_faces()));
    geometries.push_back(geometry_of(knot(3000)));
    geometries.push_back(geometry_of(make_gear_mesh(12, 1, 1.3, 0.4, 0.3)));
    geometries.push_back(geometry_of(make_needles_mesh(300, 1, 1e12, 3, 8)));
    geometries.push_back(geometry_of(make_soup_mesh(400, 1e-5, 3, 9)));
    geometries.push_back(geometry_of(make_box_mesh({1, 2, 3})));
    geometries.push_back(geometry_of(transformed("far", knot(800), 1, {-1e6, 1e6, -1e6})));
    geometries.push_back(geometry_of(transformed("tiny", make_soup_mesh(200, 0.5, 3, 11), 1e-6, {0, 0, 0})));
    geometries.push_back(geometry_of(transformed("huge", make_soup_mesh(200, 0.5, 3, 12), 1e6, {0, 0, 0})));
    geometries.push_back({"ball", Shape{Sphere{1}}, {}});
    for (const Geometry& geometry : geometries) {
        Grown gpu(geometry, 5, make_gl_compute_backend()), cpu(geometry, 5, make_cpu_backend());
        EXPECT_EQ(gpu.grow_whole(), cpu.grow_whole()) << geometry.name;
        ASSERT_EQ(gpu.known(), cpu.known());
        for (CellKey cell : cpu.known()) EXPECT_EQ(gpu.triangles(cell), cpu.triangles(cell)) << geometry.name;
    }
}

TEST(GlCompute, RepeatsABatchThatOutgrowsItsBuffersAndDropsNothing)
{
    const Geometry geometry = geometry_of(knot(6000));
    Grown small(geometry, 6, make_gl_compute_backend({.first_entries = 64})), cpu(geometry, 6, make_cpu_backend());
    EXPECT_EQ(small.grow_whole(), cpu.grow_whole());
    EXPECT_GE(small.repeats(), 3u);
    for (CellKey cell : cpu.known()) EXPECT_EQ(small.triangles(cell), cpu.triangles(cell));
}

TEST(GlCompute, KeepsItsListsWhileCellsComeAndGo)
{
    const Geometry geometry = geometry_of(knot(4000));
    Grown gpu(geometry, 5, make_gl_compute_backend({.first_entries = 4096})), cpu(geometry, 5, make_cpu_backend());
    cpu.grow_whole();
    gpu.expand({root_cell}, 0);
    std::mt19937 random(3);
    std::size_t most = 0, dropped = 0;
    for (std::uint32_t frame = 1; frame < 300; ++frame) {
        gpu.touch_root(frame);
        const CellKey cell = child_cell(root_cell, random() % 8);
        if (gpu.tree().knows(cell) && !gpu.expanded(cell)) {
            gpu.expand({cell}, frame);
            gpu.expand(gpu.children(cell), frame);
        }
        dropped += gpu.tree().collapse(frame, 3, 0, gpu.backend());
        for (CellKey known : gpu.known()) ASSERT_EQ(gpu.triangles(known), cpu.triangles(known)) << frame;
        most = std::max(most, gpu.backend().bytes());
    }
    EXPECT_GT(dropped, 1000u);
    EXPECT_LT(most, 2 * cpu.backend().bytes()) << "holes are packed";
}

TEST(GlCompute, AnswersMeshesThatDoNotFitOnTheCpu)
{
    const Geometry small = geometry_of(knot(600)), large = geometry_of(knot(6000));
    const GlComputeOptions tight{.most_buffer_bytes = 4096 * 48};
    Grown fits(small, 4, make_gl_compute_backend(tight)), too_large(large, 4, make_gl_compute_backend(tight));
    Grown cpu_small(small, 4, make_cpu_backend()), cpu_large(large, 4, make_cpu_backend());
    EXPECT_EQ(fits.grow_whole(), cpu_small.grow_whole());
    EXPECT_EQ(too_large.grow_whole(), cpu_large.grow_whole());
    EXPECT_GT(fits.gpu_bytes(), 0u);
    EXPECT_EQ(too_large.gpu_bytes(), 0u);
    for (CellKey cell : cpu_large.known()) EXPECT_EQ(too_large.triangles(cell), cpu_large.triangles(cell));
}

TEST(GlCompute, SaysSoWhenListsOutgrowTheGpu)
{
    const Geometry geometry = geometry_of(knot(3000));
    Grown gpu(geometry, 7, make_gl_compute_backend({.most_buffer_bytes = 150'000, .first_entries = 64}));
    try {
        gpu.grow_whole();
        FAIL() << "fits in 150 kB";
    } catch (const GpuLost& lost) {
        EXPECT_NE(std::string(lost.what()).find("a buffer may hold"), std::string::npos) << lost.what();
    }
}

TEST(GlCompute, ReusesTheRoomOfSurfacesThatLeft)
{
    const auto backend = make_gl_compute_backend();
    const Geometry geometry = geometry_of(knot(1000));
    const RootCell root = root_cell_of(geometry);
    backend->attach(0, make_surface(geometry, root));
    const std::size_t one = backend->bytes();
    for (std::uint32_t i = 0; i < 50; ++i) {
        backend->attach(i + 1, make_surface(geometry, root));
        EXPECT_EQ(backend->bytes(), 2 * one);
        backend->detach(i);
        EXPECT_FALSE(backend->attached(i));
    }
    EXPECT_EQ(backend->bytes(), one);
}

TEST(GlCompute, BelongsToItsThread)
{
    const auto backend = make_gl_compute_backend();
    std::string told;
    std::thread([&] {
        try {
            backend->submit({}, 1);
        } catch (const Error& error) {
            told = error.what();
        }
    }).join();
    EXPECT_NE(told.find("another thread"), std::string::npos) << told;
}

TEST(Gpu, ListsDevicesAndRefusesNumbersThatAreNone)
{
    const std::vector<GpuDevice> devices = gpu_devices();
    ASSERT_FALSE(devices.empty());
    for (std::size_t i = 0; i < devices.size(); ++i) EXPECT_FALSE(describe_gpu(int(i)).renderer.empty());
    try {
        describe_gpu(63);
        FAIL() << "there is no GPU 63";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::no_gpu);
        EXPECT_NE(std::string(error.what()).find("63"), std::string::npos);
    }
}

} // namespace
} // namespace oncollide
