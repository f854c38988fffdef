// One libFuzzer target per format: ONCOLLIDE_FORMAT names it.
#include "formats.hpp"

#include <algorithm>

using namespace oncollide::test;

namespace {

const Format& format()
{
    static const Format& named = format_named(ONCOLLIDE_FORMAT);
    return named;
}

} // namespace

extern "C" std::size_t LLVMFuzzerMutate(unsigned char* data, std::size_t size, std::size_t most);

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size)
{
    load_bytes(format(), {reinterpret_cast<const char*>(data), size});
    return 0;
}

/// Uses the mutator of the format half of the time, else libFuzzer's.
extern "C" std::size_t LLVMFuzzerCustomMutator(unsigned char* data, std::size_t size, std::size_t most, unsigned seed)
{
    std::mt19937_64 random(seed);
    if (!format().mutated || random() % 2) return LLVMFuzzerMutate(data, size, most);
    const std::string bytes = format().mutated({reinterpret_cast<const char*>(data), size}, random);
    const std::size_t length = std::min(bytes.size(), most);
    std::copy_n(bytes.data(), length, data);
    return length;
}
