// Triangles against triangles, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Bits by pair: those that are certainly separate, and those of which it is certain whether they are.
struct PairVerdicts {
    unsigned separate, known;
};

/// Triangle i of a, its 9 coordinates, against triangle i of b, for 1 to 8.
using JudgePairs = PairVerdicts(const double (*corners_a)[9], const double (*corners_b)[9], unsigned count);

namespace baseline {
JudgePairs* judge_pairs();
}
namespace avx2 {
JudgePairs* judge_pairs();
}
namespace avx512 {
JudgePairs* judge_pairs();
}

} // namespace oncollide
