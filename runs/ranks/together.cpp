#include <oncollide/runs/ranks/ranks.hpp>

#include <new>

#include <fmt/format.h>

namespace oncollide {

void together(Ranks& ranks, const std::function<void()>& work)
{
    std::uint64_t kind = 0;
    std::string what;
    try {
        work();
    } catch (const Error& error) {
        kind = std::uint64_t(error.kind()), what = error.what();
    } catch (const std::bad_alloc&) {
        kind = std::uint64_t(ErrorKind::internal), what = "out of memory";
    } catch (const std::exception& error) {
        kind = std::uint64_t(ErrorKind::internal), what = fmt::format("internal fault: {}", error.what());
    }
    std::uint64_t failed = kind != 0;
    ranks.sum({&failed, 1});
    if (!failed) return;
    Bytes mine;
    put(mine, kind), put_list(mine, what);
    std::vector<Bytes> all;
    ranks.gather(mine, all);
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        ByteReader reader(all[rank]);
        const auto its_kind = ErrorKind(reader.get<std::uint64_t>());
        const auto its_text = reader.get_list<std::string>();
        if (its_kind == ErrorKind{}) continue;
        // If all ranks fail, omit the rank's number.
        throw ErrorOfAll(its_kind, failed == all.size()
                                       ? its_text
                                       : fmt::format("process {} of {}: {}", rank, all.size(), its_text));
    }
}

} // namespace oncollide
