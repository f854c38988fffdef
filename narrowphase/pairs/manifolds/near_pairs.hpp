// Features of two surfaces that are near each other, and regions of them.
#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/key_numbers.hpp>
#include <oncollide/narrowphase/pairs/manifolds/placed_surface.hpp>

namespace oncollide {

/// Two near features, in the frame of the pair.
struct NearPair {
    FeatureBits a, b;
    std::uint32_t triangle_a, triangle_b; ///< a triangle of each feature
    std::uint8_t corners_a, corners_b;    ///< bits of the triangles' corners that span the features
    Eigen::Vector3d point_a, point_b;
    double distance;

    bool has_face() const { return corners_a == 7 || corners_b == 7; }
};

/// Finds pairs of features that are near each other. Keeps its memory.
class NearSearch {
public:
    enum class Which {
        all,
        minima, ///< where the distance has a local minimum, is more than `rounding`, and is in front of both surfaces
    };
    /// Writes all pairs within dhat, each once, sorted by (a, b). Distances err by at most `rounding`, which is added
    /// to dhat.
    /// @param near  all pairs of triangles within dhat + rounding, and perhaps others, in any order
    void find(const PlacedSurface& a, const PlacedSurface& b, std::span<const TrianglePair> near, double dhat,
              double rounding, Which which, std::vector<NearPair>& found);
    /// The least distance that find() has seen, also for features that are not minima.
    double least() const { return least_; }

private:
    /// A triangle of some near pairs. A vertex or an edge that several faces share belongs to the first of them: if it
    /// is near a feature of the other body, each of these faces is, too.
    struct Face {
        std::uint32_t triangle;
        TrianglePoints points;
        Eigen::Vector3d normal;          ///< unit, outward; 0 without area
        unsigned corners = 0, edges = 0; ///< bits of its own corners, and of the edges that begin at a corner
        unsigned tried_corners = 0, tried_edges = 0; ///< of these, the ones at which pairs are searched

        bool owns(std::uint8_t spanned) const;
    };
    /// The triangles of one body.
    struct Side {
        const PlacedSurface* surface;
        KeyNumbers triangles, vertices, edges;
        std::vector<std::uint32_t> number; ///< the number of each triangle, in the order of their first use
        std::vector<Face> faces;           ///< faces in the order of `number`

        void set(const PlacedSurface& of, std::span<const TrianglePair> near, bool is_a, Which which);
    };
    void try_pair(const Face& a, const Face& b);
    void add(const Face& a, std::uint8_t corners_a, const Eigen::Vector3d& at_a, const Face& b, std::uint8_t corners_b,
             const Eigen::Vector3d& at_b);

    Side a_, b_;
    Which which_;
    double most_, reach_, rounding_, least_;
    std::vector<NearPair>* found_;
};

/// How much distances of near features may err.
double near_rounding(const PlacedSurface& a, const PlacedSurface& b);

} // namespace oncollide
