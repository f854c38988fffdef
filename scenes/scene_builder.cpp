#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide {

SceneBodyId SceneBuilder::add_body(BodyInit body)
{
    if (scene_) return scene_->add_body(std::move(body));
    info_.check_body(body);
    const auto number = static_cast<std::uint32_t>(size());
    if (wants(number)) sink_->take(number, std::move(body));
    ++info_.size_;
    return SceneBodyId{number};
}

void SceneBuilder::reserve(std::size_t bodies)
{
    if (scene_) scene_->reserve(bodies);
}

void SceneBuilder::record(std::shared_ptr<Recording> poses)
{
    if (scene_) return scene_->record(std::move(poses));
    info_.check_bodies_of(*poses);
    info_.recording = std::move(poses);
}

void SceneBuilder::exclude(SceneBodyId a, SceneBodyId b)
{
    scene_ ? scene_->exclude(a, b) : info_.exclude_pair(a, b, {});
}

std::optional<SceneBodyId> SceneBuilder::find(std::string_view body) const
{
    return scene_ ? scene_->find(body) : std::nullopt;
}

} // namespace oncollide
