#include "cli/build_info.hpp"

#include <fmt/format.h>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/runs/report.hpp>

#include "cli/log.hpp"

namespace oncollide::tools {
namespace {

struct BuildPart {
    const char* name;
    bool built;
};

constexpr BuildPart parts[] = {{"OpenGL", ONCOLLIDE_HAS_GL},       {"FCL", ONCOLLIDE_HAS_FCL},
                               {"OctoMap", ONCOLLIDE_HAS_OCTOMAP}, {"OpenMP", ONCOLLIDE_HAS_OPENMP},
                               {"GDAL", ONCOLLIDE_HAS_GDAL},       {"HDF5", ONCOLLIDE_HAS_HDF5},
                               {"XML", ONCOLLIDE_HAS_XML},         {"MPI", ONCOLLIDE_HAS_MPI}};

std::string parts_that(bool are_built)
{
    std::string names;
    for (const BuildPart& part : parts)
        if (part.built == are_built) names += (names.empty() ? "" : ", ") + std::string(part.name);
    return names;
}

} // namespace

std::string build_text()
{
    return fmt::format("{}, {}", ONCOLLIDE_BUILD_TYPE, ONCOLLIDE_COMPILER);
}

std::string build_flags()
{
    return ONCOLLIDE_BUILD_FLAGS;
}

std::string parts_text()
{
    const std::string built = parts_that(true), without = parts_that(false);
    if (without.empty()) return built;
    return fmt::format("{}{}without {}", built, built.empty() ? "" : "; ", without);
}

bool has_gpu_backends()
{
    return ONCOLLIDE_HAS_GL;
}

std::string instruction_sets_text()
{
    std::string sets;
    for (const InstructionSet set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512})
        if (set <= best_instruction_set()) sets += fmt::format("{}{}", sets.empty() ? "" : ", ", name_of(set));
    return fmt::format("{} (in use: {})", sets, name_of(instruction_set()));
}

std::string version_text()
{
    return fmt::format("{} {}\nbuild         {}, flags '{}'\nparts         {}\ninstructions  {}", program_name(),
                       version, build_text(), build_flags(), parts_text(), instruction_sets_text());
}

} // namespace oncollide::tools
