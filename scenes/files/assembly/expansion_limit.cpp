#include <oncollide/scenes/files/assembly/expansion_limit.hpp>

#include <algorithm>

#include <fmt/format.h>

namespace oncollide {

void ExpansionLimit::spend(std::uint64_t pieces, std::uint64_t beside)
{
    if (pieces > 0) check(spent_ += pieces, beside);
}

void ExpansionLimit::expect_parts(std::uint64_t parts, std::uint64_t written)
{
    parts_ += parts, written_ += written;
    if (parts_ > std::max(most_parts_, written_))
        source_.fail(fmt::format("its instances make {} parts or more; the limit is {} (--max-parts)", parts_,
                                 std::max(most_parts_, written_)));
}

void ExpansionLimit::check(std::uint64_t spent, std::uint64_t beside) const
{
    constexpr std::uint64_t always = 10'000'000, never = 200'000'000;
    if (spent <= always) return;
    const std::uint64_t most = std::clamp<std::uint64_t>(source_.bytes.size() + beside, always, never);
    if (spent > most)
        source_.fail(fmt::format("its nodes expand to more than {} triangles, vertices and parts of meshes; the limit "
                                 "is the size of its files in bytes, but at least {} and at most {}",
                                 most, always, never));
}

} // namespace oncollide
