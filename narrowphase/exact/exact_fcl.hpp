#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// False in builds without FCL (ONCOLLIDE_FCL=OFF): there an ExactFcl can be made, and its other functions throw.
bool fcl_available();

/// The exact level by way of FCL, on bodies whole: triangle against triangle for meshes, libccd for shapes, boxes for
/// the cells of an octomap. FCL's models are made when first needed, one a geometry.
class ExactFcl {
public:
    /// @param clearance  metres; above 0 distances are asked too
    ExactFcl(const Scene& scene, double clearance);
    ~ExactFcl();

    /// Makes what `geometry` needs. Not thread-safe; call before answer().
    /// Cost: a bounding-volume tree, about 3 microseconds a triangle.
    void prepare(GeometryId geometry);

    struct Answer {
        Verdict verdict;                      ///< colliding, within (not colliding, distance <= clearance) or separate
        double bound;                         ///< colliding: 0; else the distance when clearance > 0, else 0
        int triangle_a = -1, triangle_b = -1; ///< two that meet, when both bodies are meshes and collide
    };
    /// Thread-safe once both geometries are prepared.
    Answer answer(const Scene& scene, std::uint32_t a, std::uint32_t b) const;

    bool both_meshes(const Scene& scene, std::uint32_t a, std::uint32_t b) const;
    /// True when FCL's triangle test finds one of these triangles of mesh a to meet one of these of mesh b.
    /// Thread-safe, needs no preparation.
    /// @param scratch  working memory, one a thread
    bool triangles_meet(const Scene& scene, std::uint32_t a, std::uint32_t b, std::span<const std::uint32_t> of_a,
                        std::span<const std::uint32_t> of_b, std::vector<Aabb>& scratch) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
