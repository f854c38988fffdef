#pragma once
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide::test {

/// Loads a scene file, which may name generators.
inline Scene load_with_samples(const std::filesystem::path& path)
{
    return load_scene(path, {.generators = &sample_generators()});
}

} // namespace oncollide::test
