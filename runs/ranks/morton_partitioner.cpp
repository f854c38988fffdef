#include <algorithm>
#include <cmath>

#include <oncollide/runs/ranks/partitioner.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using Key = std::uint64_t; ///< three coordinates of 20 bits, interleaved

constexpr int levels = 20;

Key spread(std::uint32_t x)
{
    Key bits = x;
    bits = (bits | bits << 32) & 0x1f00000000ffffull, bits = (bits | bits << 16) & 0x1f0000ff0000ffull;
    bits = (bits | bits << 8) & 0x100f00f00f00f00full, bits = (bits | bits << 4) & 0x10c30c30c30c30c3ull;
    return (bits | bits << 2) & 0x1249249249249249ull;
}

struct Sample {
    Key key;
    double weight;
};

class MortonPartitioner final : public Partitioner {
public:
    void rebuild(Ranks& ranks, std::span<const Vector3d> points, std::span<const float> weights) override
    {
        fit_grid(ranks, points);
        std::vector<Sample> mine;
        for (std::size_t i = 0; i < points.size(); ++i) mine.push_back({key(cell(points[i])), weights[i]});
        std::ranges::sort(mine, {}, &Sample::key);
        Bytes bytes;
        // Each sample represents an equal share of this rank's weight.
        double all = 0, taken = 0, heard = 0;
        for (const Sample& s : mine) all += s.weight;
        const double share = all / samples_of_a_rank;
        for (const Sample& s : mine) {
            heard += s.weight;
            if (heard - taken >= share) put(bytes, Sample{s.key, heard - taken}), taken = heard;
        }
        std::vector<Bytes> gathered;
        ranks.gather(bytes, gathered);
        split(ranks.size(), gathered);
    }

    int owner(const Vector3d& point) const override { return owner(key(cell(point))); }

    void ranks(const Aabb& box, std::vector<int>& ranks) const override
    {
        ranks.clear();
        visit(cell(box.min), cell(box.max), 0, 0, ranks);
    }

private:
    using Cell = std::array<std::uint32_t, 3>;
    static constexpr int samples_of_a_rank = 256;

    void fit_grid(Ranks& ranks, std::span<const Vector3d> points)
    {
        Aabb all;
        for (const Vector3d& point : points) all.add(point);
        std::array<double, 6> ends{-all.min.x(), -all.min.y(), -all.min.z(), all.max.x(), all.max.y(), all.max.z()};
        ranks.most(ends);
        origin_ = -Vector3d(ends[0], ends[1], ends[2]);
        const double edge = (Vector3d(ends[3], ends[4], ends[5]) - origin_).maxCoeff();
        cells_ = edge > 0 && std::isfinite(edge) ? (1u << levels) / edge : 0; // 0: all points coincide, or there are
                                                                              // none
        if (!origin_.allFinite()) origin_.setZero();
    }
    /// Splits into ranges of equal weight, as far as the samples allow.
    void split(int size, const std::vector<Bytes>& gathered)
    {
        std::vector<Sample> samples;
        for (const Bytes& theirs : gathered)
            for (ByteReader reader(theirs); !reader.at_end();) samples.push_back(reader.get<Sample>());
        std::ranges::stable_sort(samples, {}, &Sample::key);
        double all = 0, seen = 0;
        for (const Sample& s : samples) all += s.weight;
        begins_.clear();
        for (const Sample& s : samples) {
            seen += s.weight;
            while (int(begins_.size()) < size - 1 && seen >= all * double(begins_.size() + 1) / size)
                begins_.push_back(s.key + 1);
        }
    }

    /// Used for points and for corners of boxes: monotonic in each coordinate, so a box's cells include its points'
    /// cells.
    Cell cell(const Vector3d& point) const
    {
        Cell c;
        for (int k = 0; k < 3; ++k) {
            const double at = (point[k] - origin_[k]) * cells_;
            c[std::size_t(k)] = at > 0 ? static_cast<std::uint32_t>(std::min(at, double((1u << levels) - 1))) : 0;
        }
        return c;
    }
    static Key key(const Cell& c) { return spread(c[0]) | spread(c[1]) << 1 | spread(c[2]) << 2; }
    int owner(Key k) const { return int(std::ranges::upper_bound(begins_, k) - begins_.begin()); }

    /// @param first, depth  the first key and the depth of an octree cell
    void visit(const Cell& lo, const Cell& hi, Key first, int depth, std::vector<int>& ranks) const
    {
        const Key last = first + ((Key{1} << 3 * (levels - depth)) - 1);
        const int from = owner(first), to = owner(last);
        if (from == to) {
            add(ranks, from);
            return;
        }
        const int shift = levels - depth - 1; // edge length of an octant: 2^shift
        const Cell at = corner(first);
        bool whole = true;
        for (std::size_t k = 0; k < 3; ++k) whole &= lo[k] <= at[k] && at[k] + ((2u << shift) - 1) <= hi[k];
        if (whole) {
            for (int rank = from; rank <= to; ++rank) add(ranks, rank);
            return;
        }
        for (unsigned octant = 0; octant < 8; ++octant) {
            bool touches = true;
            for (unsigned k = 0; k < 3; ++k) {
                const std::uint32_t begin = at[k] + ((octant >> k & 1) << shift);
                touches &= begin <= hi[k] && lo[k] <= begin + ((1u << shift) - 1);
            }
            if (touches) visit(lo, hi, first + (Key{octant} << 3 * shift), depth + 1, ranks);
        }
    }
    /// Cells are visited in the order of their keys, so ranks ascend.
    static void add(std::vector<int>& ranks, int rank)
    {
        if (ranks.empty() || ranks.back() < rank) ranks.push_back(rank);
    }
    static Cell corner(Key first)
    {
        Cell c{};
        for (unsigned bit = 0; bit < levels; ++bit)
            for (unsigned k = 0; k < 3; ++k) c[k] |= static_cast<std::uint32_t>(first >> (3 * bit + k) & 1) << bit;
        return c;
    }

    Vector3d origin_ = Vector3d::Zero();
    double cells_ = 0;        ///< per metre
    std::vector<Key> begins_; ///< first keys of all regions except the first
};

} // namespace

std::unique_ptr<Partitioner> make_morton_partitioner()
{
    return std::make_unique<MortonPartitioner>();
}

} // namespace oncollide
