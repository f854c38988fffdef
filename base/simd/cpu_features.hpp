#pragma once
#include <string_view>

namespace oncollide {

/// Instruction sets that hot code is compiled for. All give identical bits: no fused or reordered arithmetic.
enum class InstructionSet { baseline, avx2, avx512 };

/// The best set that this processor has.
InstructionSet best_instruction_set();

/// The set in use: the best one, unless the environment variable ONCOLLIDE_ISA (baseline, avx2, avx512; read once)
/// names a lower one. A higher or unknown value is ignored.
InstructionSet instruction_set();

std::string_view name_of(InstructionSet set);

template <class Kernel>
Kernel choose(Kernel baseline, Kernel avx2, Kernel avx512)
{
    const Kernel kernels[] = {baseline, avx2, avx512};
    return kernels[static_cast<int>(instruction_set())];
}

/// ONCOLLIDE_CHOOSE(walk_kernel) calls walk_kernel() in the namespace of instruction_set(): baseline, avx2 or avx512
/// (see oncollide_add_kernel; the demo has the baseline alone).
#if defined(__x86_64__) && !defined(ONCOLLIDE_BASELINE_ALONE)
#define ONCOLLIDE_CHOOSE(kernel) choose(baseline::kernel(), avx2::kernel(), avx512::kernel())
/// The same for kernels that are not built for AVX-512.
#define ONCOLLIDE_CHOOSE_TO_AVX2(kernel) choose(baseline::kernel(), avx2::kernel(), avx2::kernel())
#else
#define ONCOLLIDE_CHOOSE(kernel) baseline::kernel()
#define ONCOLLIDE_CHOOSE_TO_AVX2(kernel) baseline::kernel()
#endif

} // namespace oncollide
