// Prints the result hash of every scene of the catalogue, small, at three settings: equal for every system, compiler
// and processor (hashes.txt).
#include <cstdio>
#include <string>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/motion.hpp>

int main()
try {
    using namespace oncollide;
    constexpr int bodies = 60, frames = 6;
    const struct {
        const char* name;
        Settings settings;
    } variants[] = {{"exact", {}}, {"max-error", {.max_error = 0.02}}, {"depth", {.depth = 5}}};
    for (const CatalogueEntry& entry : catalogue()) {
        CatalogueOptions options{.data = {}};
        const bool fixed = entry.name == "paper" || entry.name == "paper-5k" || entry.name == "hard";
        if (!fixed) options.bodies = bodies;
        for (const auto& variant : variants) {
            Scene scene = make_scene(entry.name, options);
            Pipeline pipeline(scene, variant.settings);
            Mover mover;
            std::size_t pairs = 0;
            for (int frame = 0; frame < frames; ++frame) {
                mover.move(scene, frame * scene.frames / frames); // bodies that are far apart at first meet later
                for (const PairResult& pair : pipeline.step(scene).pairs) pairs += pair.verdict != Verdict::separate;
            }
            std::printf("%s %s %016llx %zu\n", entry.name.c_str(), variant.name,
                        static_cast<unsigned long long>(pipeline.hash()), pairs);
        }
    }
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
