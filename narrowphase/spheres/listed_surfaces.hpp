#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/spheres/octant_cell.hpp>
#include <oncollide/narrowphase/spheres/triangle_lists.hpp>

namespace oncollide {

/// The surfaces of trees with the triangle lists of their cells, in main memory, and the octant test that fills them:
/// for backends that test octants, or choose the triangles to draw, on the CPU.
class ListedSurfaces {
public:
    void attach(std::uint32_t tree, Surface surface);
    bool attached(std::uint32_t tree) const { return tree < trees_.size() && trees_[tree]; }
    void detach(std::uint32_t tree);
    const Surface& surface(std::uint32_t tree) const { return trees_[tree]->surface; }
    std::size_t bytes() const; ///< bytes of surfaces and kept lists

    /// How find() tests triangles, and which results it stores.
    struct Find {
        bool boxes = false;  ///< tests triangles by their boxes alone: faster, and still conservative
        float inflation = 0; ///< octants grow on every side by this fraction of the cell's largest half-extent
        bool all = false;    ///< also stores the triangles of rows without keep_list
    };
    /// Finds the triangles of each row and the octants that each enters. Independent of the number of threads.
    void find(std::span<const OctantRow> rows, const Find& how, int threads);
    /// Results of the last find() for its row number `row`: octants that triangles enter, octants inside a solid shape,
    /// and the triangles, none if they were not to be stored.
    std::uint8_t entered(std::size_t row) const { return found_[row].entered; }
    std::uint8_t inside(std::size_t row) const { return found_[row].inside; }
    TriangleSpan triangles(std::size_t row, unsigned octant) const;

    /// Keeps the triangles found for a row.
    ListId keep(std::uint32_t tree, std::size_t row);
    void release(std::uint32_t tree, ListId list) { trees_[tree]->lists.release(list); }
    /// As OcclusionBackend::read().
    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) const;

private:
    struct Tree {
        Surface surface;
        TriangleLists lists;
    };
    struct Worker { ///< the results of one thread
        std::vector<std::uint32_t> ids;
        std::vector<std::uint8_t> masks;
    };
    struct Found {
        std::uint32_t worker, offset, count;
        std::uint8_t entered, inside;
    };

    TriangleSpan span_of(std::uint32_t tree, ListId list, unsigned octant) const;
    Found test(const OctantRow& row, const Find& how, std::uint32_t worker_index);

    std::vector<std::optional<Tree>> trees_;
    std::vector<Worker> workers_;
    std::vector<Found> found_;
};

} // namespace oncollide
