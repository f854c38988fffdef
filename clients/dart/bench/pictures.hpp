// Pictures of a scene's end state, one for each detector side by side.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <dart/collision/CollisionResult.hpp>
#include <dart/dynamics/Shape.hpp>

#include "render/framing.hpp"

namespace dart::collision::oncollide_client::bench {

/// The bodies and the contacts that a picture shows.
class View {
public:
    enum class Role {
        moving,
        fixed, ///< does not count for the camera
        glass, ///< only its far side is drawn
    };
    void add(const dynamics::Shape& shape, const Eigen::Isometry3d& pose, Role role);
    void see(const Eigen::Vector3d& point) { to_see_.push_back(point); } ///< The camera shows it, too.
    /// Adds red marks.
    void add(const CollisionResult& contacts);

private:
    friend void save_pictures(const std::filesystem::path& path, const std::vector<View>& views);

    std::vector<std::shared_ptr<oncollide::Mesh>> meshes_; ///< the picture points to them
    oncollide::Picture picture_;
    std::vector<Eigen::Vector3d> to_see_;
    std::size_t moving_ = 0;
};

/// Writes a PNG with the views from left to right, all from the camera that shows the last one.
void save_pictures(const std::filesystem::path& path, const std::vector<View>& views);

} // namespace dart::collision::oncollide_client::bench
