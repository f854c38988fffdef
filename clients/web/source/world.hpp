#pragma once
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <oncollide/pipeline/world.hpp>

namespace oncollide::web {

/// A World that JavaScript holds, until oc_world_free().
///
/// Ids are numbers in JavaScript: slot + 2^32 generation + 2^48 (the low five bits of the World's tag), all of them
/// exact.
struct HeldWorld {
    World world;
    std::uint16_t tag = 0;            ///< in the ids of this World; known with the first model
    std::optional<FrameView> frame{}; ///< of the last step; its lists stay until the next one

    /// A number that is no such id becomes null, which the World refuses.
    template <class Id>
    Id id(double number) const
    {
        if (!(number >= 0 && number < 0x1p53) || number != std::floor(number)) return {};
        const auto bits = static_cast<std::uint64_t>(number);
        const bool own = static_cast<std::uint16_t>(bits >> 48) == (tag & 31);
        return {static_cast<std::uint32_t>(bits), static_cast<std::uint16_t>(bits >> 32),
                own ? tag : static_cast<std::uint16_t>(~tag)};
    }
    BodyId body(double number) const { return id<BodyId>(number); }
    ModelId model(double number) const { return id<ModelId>(number); }
    std::vector<BodyId> bodies(const double* numbers, std::size_t count) const
    {
        std::vector<BodyId> ids(count);
        for (std::size_t i = 0; i < count; ++i) ids[i] = body(numbers[i]);
        return ids;
    }
};

template <class Id>
double number_of(Id id)
{
    return id.slot + 0x1p32 * id.generation + 0x1p48 * (id.world & 31);
}

} // namespace oncollide::web
