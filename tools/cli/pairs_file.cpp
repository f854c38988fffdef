#include "cli/pairs_file.hpp"

#include <fmt/format.h>

#include <oncollide/pipeline/report.hpp>

namespace oncollide::tools {
namespace {

ResultsHeader header_of(const Scene& scene, const Pipeline& pipeline, bool separate)
{
    ResultsHeader header{.version = std::string(version), .scene = scene.name, .bodies = scene.size()};
    Settings settings = pipeline.settings(); // but for what never changes a result
    settings.threads = 1, settings.backend = BackendKind::cpu, settings.gpu = Settings{}.gpu;
    header.settings = fmt::format("{{\"bodies\": {}, \"pace\": {}, \"separate\": {}, \"run\": {}}}", scene.size(),
                                  scene.pace, separate, settings_json(settings));
    for (int v = 0; v <= int(Verdict::undecided); ++v) header.verdicts.emplace_back(name_of(Verdict(v)));
    for (int k = 0; k <= int(ContactKind::enclosed); ++k) header.kinds.emplace_back(name_of(ContactKind(k)));
    header.stages.assign(pipeline.stages().begin(), pipeline.stages().end());
    return header;
}

} // namespace

PairsFile::PairsFile(const std::filesystem::path& path, const Scene& scene, Pipeline& pipeline, int frame,
                     bool separate)
    : pipeline_(pipeline), separate_(separate),
      file_(path, header_of(scene, pipeline, separate), scene.names, static_cast<std::uint64_t>(frame))
{
    if (frame) pipeline.world().continue_from(static_cast<std::uint32_t>(frame), file_.chain());
}

void PairsFile::add(const FrameView& frame)
{
    rows_.clear();
    for (const PairResult& pair : frame.pairs)
        if (separate_ || pair.verdict != Verdict::separate)
            rows_.push_back({index(pair.a), index(pair.b), static_cast<std::uint8_t>(pair.verdict), pair.stage,
                             static_cast<std::uint8_t>(pair.kind), pair.bound,
                             pipeline_.world().max_error(pair.a, pair.b)});
    file_.add(
        rows_,
        {.frame = frame.frame, .first = 0, .pairs = 0, .hash = frame.hash, .chain = pipeline_.hash(), .ms = frame.ms});
}

} // namespace oncollide::tools
