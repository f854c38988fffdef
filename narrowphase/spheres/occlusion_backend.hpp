#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/spheres/cell_key.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>

namespace oncollide {

/// Identifies the list of triangles that a backend found in a cell, with the octants that each enters. Opaque to
/// callers.
enum class ListId : std::uint32_t {};
constexpr ListId all_triangles{std::numeric_limits<std::uint32_t>::max()}; ///< the whole surface: the root's list

/// Requests which of the eight octants of this cell the surface enters.
struct OctantRow {
    std::uint32_t tree; ///< a surface given to attach()
    CellKey cell;
    ListId list;    ///< list of the parent's result, or all_triangles for the root
    bool keep_list; ///< deeper cells will need the triangles
};

struct OctantResult {
    std::uint8_t grey = 0;       ///< bit k: octant k
    ListId list = all_triangles; ///< the cell's triangles, if kept
};

/// The triangles of one octant of a tested cell.
struct ListRead {
    std::uint32_t tree;
    ListId list;
    unsigned octant;
};

/// The cost of one batch. 0 if the value does not apply to a backend.
struct BatchWork {
    double gpu_ms = 0;         ///< between the first and the last command of the batch, by the GPU's clock
    double wait_ms = 0;        ///< the caller waited for the GPU
    std::uint64_t queries = 0; ///< occlusion queries
    std::uint64_t bytes = 0;   ///< bytes moved to the GPU and back
    std::uint64_t repeats = 0; ///< repetitions of the batch because a buffer was too small
};

/// The GPU was lost or ran out of memory: all lists are lost. Another backend can rebuild everything.
class GpuLost : public Error {
public:
    explicit GpuLost(const std::string& message) : Error(ErrorKind::no_gpu, message) {}
};

/// Finds grey octants. The one rule: *never clear the bit of an octant that the surface enters; a set bit may be
/// false*. If it is false, the surface is no farther from the octant than RootCell::test_error() plus error(). Results
/// depend on the rows alone, not on their order or number, nor on earlier batches.
///
/// Any call may throw GpuLost; the backend is then unusable.
class OcclusionBackend {
public:
    virtual ~OcclusionBackend() = default;
    /// For reports: "cpu (avx2)".
    virtual std::string name() const = 0;
    /// GL_RENDERER; empty on the CPU.
    virtual std::string renderer() const { return {}; }
    /// The error of a grey octant beyond RootCell::test_error() (m), for cells of half-extent `half`.
    virtual double error(double half) const = 0;

    /// Sets the surface of a tree, before its first row.
    virtual void attach(std::uint32_t tree, Surface surface) = 0;
    virtual bool attached(std::uint32_t tree) const = 0;
    /// Drops a tree's surface and lists. Like release(), name() and bytes(), it never throws.
    virtual void detach(std::uint32_t tree) = 0;

    /// Starts a batch: one per round, for all pairs and all trees. `rows` must not change until collect(), and no other
    /// call may come in between. The caller can do other work meanwhile.
    virtual void submit(std::span<const OctantRow> rows, int threads) = 0;
    /// Waits for the batch: results[i] for rows[i].
    virtual BatchWork collect(std::span<OctantResult> results) = 0;
    /// Both steps together.
    BatchWork run(std::span<const OctantRow> rows, int threads, std::span<OctantResult> results)
    {
        submit(rows, threads);
        return collect(results);
    }

    /// Releases a list whose cell was dropped.
    virtual void release(std::uint32_t tree, ListId list) = 0;
    /// Appends the triangles of each read to `triangles`, ascending, and their ends to `ends`. One call serves many
    /// reads, because lists may be on the GPU.
    virtual void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
                      std::vector<std::size_t>& ends) = 0;
    /// Memory held for surfaces and lists.
    virtual std::size_t bytes() const = 0;
};

/// For each triangle it tests the triangle's box against the octants' planes by a table, then separating axes against
/// all eight octants at once.
std::unique_ptr<OcclusionBackend> make_cpu_backend();

} // namespace oncollide
