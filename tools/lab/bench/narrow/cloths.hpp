#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Two meshes, of which the first or both deform from frame to frame.
class ClothScene {
public:
    ClothScene(std::string name, int deforming, Mesh a, Mesh b)
        : name_(std::move(name)), deforming_(deforming), rest_{std::move(a), std::move(b)}
    {
    }

    const std::string& name() const { return name_; }
    int deforming() const { return deforming_; }                             ///< meshes: 1 or 2
    int frames() const { return static_cast<int>(vertices_[0].size()) - 1; } ///< after frame 0
    std::span<const Eigen::Vector3d> vertices(int which, int frame) const
    {
        return which < deforming_ ? std::span(vertices_[which][std::size_t(frame)]) : std::span(rest_[which].vertices);
    }
    Mesh mesh(int which, int frame) const;
    void add_frame(int which, std::vector<Eigen::Vector3d> vertices)
    {
        vertices_[which].push_back(std::move(vertices));
    }
    const Mesh& rest(int which) const { return rest_[which]; }

private:
    std::string name_;
    int deforming_;
    Mesh rest_[2];
    std::vector<std::vector<Eigen::Vector3d>> vertices_[2]; ///< by frame
};

/// A waving cloth of about `triangles` triangles, side 1, that touches a ball with about 1 % of its triangles; and two
/// cloths that pass through each other.
std::vector<ClothScene> cloth_scenes(int triangles, int frames);

} // namespace oncollide::tools
