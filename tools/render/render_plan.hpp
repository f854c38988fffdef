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
    bool whole = false, quiet = false;
};

/// One file to be written: its frames side by side, and of each frame the levels.
struct ImagePlan {
    std::string file;
    std::vector<int> frames; ///< ascending
};

/// What is to be drawn.
struct RenderPlan {
    std::vector<ImagePlan> images;          ///< frames ascend from image to image too
    std::vector<std::optional<int>> levels; ///< none: the finest spheres known
    int deepest = 0;                        ///< of the levels
    int width, height;                      ///< of an image, pixels
    int panels() const { return int(images.front().frames.size() * levels.size()); }
};

// All throw Error{usage} for options that make no sense, alone or with this scene.
RenderPlan plan_from(const RenderOptions& options, const Settings& settings, const Scene& scene);
ScenePictures::Shown shown_from(const RenderOptions& options, const Scene& scene);

/// What the options say of the camera, over the one that sees everything.
class View {
public:
    explicit View(const RenderOptions& options);
    /// Whether it depends on what is seen.
    bool automatic() const { return !(eye_ && look_at_); }
    Camera camera(const Framing& framing) const;

private:
    std::optional<Eigen::Vector3d> eye_, look_at_;
};

} // namespace oncollide::tools
