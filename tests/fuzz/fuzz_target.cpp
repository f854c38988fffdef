// One libFuzzer target a format: ONCOLLIDE_FORMAT names it.
#include "formats.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size)
{
    using namespace oncollide::test;
    static const Format& format = format_named(ONCOLLIDE_FORMAT);
    load_bytes(format, {reinterpret_cast<const char*>(data), size});
    return 0;
}
