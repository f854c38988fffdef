#pragma once
#include <string_view>

namespace oncollide {

/// Instruction sets that hot code is compiled for. All give the same bits: no fused or reordered arithmetic.
enum class InstructionSet { baseline, avx2, avx512 };

/// The best set that this processor has, asked once. The environment variable ONCOLLIDE_ISA (baseline, avx2, avx512)
/// can lower it, never raise it; an unknown value is ignored.
InstructionSet instruction_set();

std::string_view name_of(InstructionSet set);

/// Of three builds of one kernel, the one of instruction_set().
template <class Kernel>
Kernel choose(Kernel baseline, Kernel avx2, Kernel avx512)
{
    const Kernel kernels[] = {baseline, avx2, avx512};
    return kernels[static_cast<int>(instruction_set())];
}

} // namespace oncollide
