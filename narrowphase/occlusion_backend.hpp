#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/cell_key.hpp>
#include <oncollide/narrowphase/surface.hpp>

namespace oncollide {

/// Where a backend keeps the triangles that it found in a cell, each with the octants that it enters. Opaque above.
enum class ListId : std::uint32_t {};
constexpr ListId all_triangles{std::numeric_limits<std::uint32_t>::max()}; ///< the whole surface: the root's list

/// One question: which of the eight octants of this cell does the surface enter?
struct OctantRow {
    std::uint32_t tree; ///< a surface given to attach()
    CellKey cell;
    ListId list;    ///< the parent's answer, or all_triangles for the root
    bool keep_list; ///< the triangles will be asked for again, by deeper cells
};

struct OctantAnswer {
    std::uint8_t grey = 0;       ///< bit k: octant k
    ListId list = all_triangles; ///< the cell's triangles, when kept
};

/// Who answers. The one rule: *never clear the bit of an octant that the surface enters; a set bit may be false*, and
/// then the surface is no farther from the octant than RootCell::false_reach() plus reach(). Answers depend on the rows
/// alone, not on their order or number, nor on what was asked before.
class OcclusionBackend {
public:
    virtual ~OcclusionBackend() = default;
    /// For reports: "cpu (avx2)".
    virtual std::string name() const = 0;
    /// What a grey octant may be wrong by beyond RootCell::false_reach() (m), for cells of half-extent `half`.
    virtual double reach(double half) const = 0;

    /// Gives the surface of a tree before its first row.
    virtual void attach(std::uint32_t tree, Surface surface) = 0;
    virtual bool attached(std::uint32_t tree) const = 0;
    /// Forgets a tree's surface and lists.
    virtual void detach(std::uint32_t tree) = 0;

    /// answers[i] for rows[i]. One batch a round, for all pairs and all trees.
    virtual void ask(std::span<const OctantRow> rows, int threads, std::span<OctantAnswer> answers) = 0;
    /// The cell of that list was dropped.
    virtual void release(std::uint32_t tree, ListId list) = 0;
    /// Appends the triangles of a list that enter `octant`, ascending.
    virtual void read(std::uint32_t tree, ListId list, unsigned octant,
                      std::vector<std::uint32_t>& triangles) const = 0;
    /// Memory held for surfaces and lists.
    virtual std::size_t bytes() const = 0;
};

/// Per triangle: its box against the octants' planes by table, then separating axes against the eight octants at once.
std::unique_ptr<OcclusionBackend> make_cpu_backend();

} // namespace oncollide
