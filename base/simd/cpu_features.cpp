#include <oncollide/base/simd/cpu_features.hpp>

#include <algorithm>
#include <cstdlib>

namespace oncollide {

std::string_view name_of(InstructionSet set)
{
    constexpr std::string_view names[] = {"baseline", "avx2", "avx512"};
    return names[static_cast<int>(set)];
}

InstructionSet best_instruction_set()
{
#if defined(__x86_64__) && !defined(ONCOLLIDE_BASELINE_ALONE)
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
    if (!avx2) return InstructionSet::baseline;
    const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
    return avx512 ? InstructionSet::avx512 : InstructionSet::avx2;
#else
    return InstructionSet::baseline;
#endif
}

namespace {

InstructionSet chosen()
{
    const InstructionSet best = best_instruction_set();
    if (const char* wish = std::getenv("ONCOLLIDE_ISA"))
        for (InstructionSet set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512})
            if (name_of(set) == wish) return std::min(set, best);
    return best;
}

} // namespace

InstructionSet instruction_set()
{
    static const InstructionSet set = chosen();
    return set;
}

} // namespace oncollide
