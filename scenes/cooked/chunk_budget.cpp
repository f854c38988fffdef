#include <oncollide/scenes/cooked/chunk_budget.hpp>

#include <fmt/format.h>

#include <oncollide/scenes/cooked/chunk_fault.hpp>

namespace oncollide {

void ChunkBudget::take(std::size_t bytes, const std::string& who)
{
    const std::size_t before = held_.fetch_add(bytes, std::memory_order_relaxed);
    advance();
    if (limit_ == 0 || before + bytes <= limit_) return;
    give(bytes);
    throw NoRoomForChunk(ErrorKind::bad_data,
                         fmt::format("{}: the chunks that one pair needs do not fit into the {} bytes that chunks may "
                                     "hold (--resident, Settings::resident_budget)",
                                     who, limit_));
}

} // namespace oncollide
