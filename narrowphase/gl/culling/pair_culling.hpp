#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <Eigen/Geometry>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A mesh at a pose, by the number given to attach().
struct CulledBody {
    std::uint32_t mesh;
    Eigen::Isometry3d pose;
};

struct CullingWork {
    double gpu_ms = 0; ///< between the first and the last command, by the GPU's clock
    std::uint64_t queries = 0;
};

/// A published method that drops pairs of bodies by occlusion queries, for comparison with sphere-trees. A mesh is its
/// surface. Any call may throw GpuLost. Belongs to the thread that made it.
class PairCulling {
public:
    virtual ~PairCulling() = default;
    virtual std::string name() const = 0; ///< the method's name and options
    virtual std::string renderer() const = 0;
    /// Sets a mesh, before it is used. Keeps no reference to it.
    virtual void attach(std::uint32_t number, const Mesh& mesh) = 0;
    /// Sets left[i] to 1 if pairs[i], two indices of `bodies`, may collide, else to 0.
    virtual CullingWork cull(std::span<const CulledBody> bodies, std::span<const BodyPair> pairs,
                             std::span<std::uint8_t> left) = 0;
};

/// The potentially colliding set of CULLIDE: a body, and then each of its subsets of triangles, leaves the set if it is
/// fully visible before the bodies that precede it in the list, and before the bodies that follow. Source: Govindaraju,
/// Redon, Lin and Manocha, "CULLIDE: interactive collision detection between complex models in large environments using
/// graphics hardware", Graphics Hardware 2003.
///
/// `fattened` draws a box around each triangle, enlarged by a pixel, so that no collision is missed. Source:
/// Govindaraju, Lin and Manocha, "Fast and reliable collision culling using graphics hardware", VRST 2004 (FAR).
struct CullideOptions {
    int gpu = -1;
    int viewport = 512; ///< pixels per side, 16 to 1024
    int subset = 64;    ///< most triangles in a subset
    bool fattened = false;
};
std::unique_ptr<PairCulling> make_cullide(const CullideOptions& options = {});

/// Boxes around parts of the body with fewer triangles are viewing volumes, in which the other body is drawn. The pair
/// is dropped if no volume has a fragment, seen along any axis. After Fan, Wan and Gao, "Simple and rapid collision
/// detection using multiple viewing volumes", VRCAI 2004.
struct ViewingVolumesOptions {
    int gpu = -1;
    int viewport = 64; ///< pixels per side, 1 to 1024
    int volumes = 8;   ///< number of viewing volumes of a body
};
std::unique_ptr<PairCulling> make_viewing_volumes(const ViewingVolumesOptions& options = {});

} // namespace oncollide
