// A recording of bodies that a benchmark moves, as a scene file for 'oncollide run'.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

class PoseRecord {
public:
    /// @param scene  its first body stays where it is
    explicit PoseRecord(const Scene& scene) : scene_(scene) {}
    /// Adds a frame: the poses of all bodies.
    void add(std::span<const Eigen::Isometry3d> poses);
    /// Writes the scene without its motions and, beside it, the poses: "slide.json" and "slide-poses.npy". Throws
    /// Error{cannot_write}.
    void save(const std::filesystem::path& path) const;

private:
    const Scene& scene_;
    std::vector<float> numbers_;
};

} // namespace oncollide::tools
