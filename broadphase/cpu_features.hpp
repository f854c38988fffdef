#pragma once
#include <string_view>

namespace oncollide {

/// Instruction sets that hot code is compiled for. All give the same bits: no fused or reordered arithmetic.
enum class InstructionSet { baseline, avx2, avx512 };

/// The best set that this processor has, asked once. The environment variable ONCOLLIDE_ISA (baseline, avx2, avx512)
/// can lower it, never raise it; an unknown value is ignored.
InstructionSet instruction_set();

std::string_view name_of(InstructionSet set);

} // namespace oncollide
