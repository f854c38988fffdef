#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cli/options.hpp"
#include "render/framing.hpp"
#include "render/render_scene.hpp"

namespace oncollide::tools {

struct RenderOptions {
    SceneOptions scene;
    SettingsOptions settings;
    std::vector<int> frames, levels;
    std::optional<int> every;
    std::string out, size = "1280x720", show = "both", eye, look_at;
    std::vector<std::string> bodies;
    bool whole = false, rays = false, quiet = false;
};

/// A file to write: frames side by side, and for each frame its levels.
struct ImagePlan {
    std::string file;
    std::vector<int> frames; ///< ascending
};

/// All images to draw.
struct RenderPlan {
    std::vector<ImagePlan> images;          ///< frames ascend across images, too
    std::vector<std::optional<int>> levels; ///< nullopt: the finest known spheres
    int deepest = 0;                        ///< deepest of the levels
    int width, height;                      ///< size of an image, pixels
    int panels() const { return int(images.front().frames.size() * levels.size()); }
};

// All throw Error{usage} for options that are invalid, by themselves or for this scene.
RenderPlan plan_from(const RenderOptions& options, const Settings& settings, const Scene& scene);
ScenePictures::Shown shown_from(const RenderOptions& options, const Settings& settings, const Scene& scene);

/// The camera options, applied to the automatic camera.
class View {
public:
    explicit View(const RenderOptions& options);
    /// True if the camera depends on the contents.
    bool automatic() const { return !(eye_ && look_at_); }
    Camera camera(const Framing& framing) const;

private:
    std::optional<Eigen::Vector3d> eye_, look_at_;
};

} // namespace oncollide::tools
