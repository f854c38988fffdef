#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace oncollide {

/// A body: its slot, and how often that slot had been given away before. A Scene never removes bodies, so there the
/// generation is always 0 and the slot is the index into its columns.
struct BodyId {
    std::uint32_t slot = 0;
    std::uint32_t generation = 0;

    friend constexpr auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// A model, in the same form.
struct ModelId {
    std::uint32_t slot = 0;
    std::uint32_t generation = 0;

    friend constexpr auto operator<=>(const ModelId&, const ModelId&) = default;
};

/// A geometry of a Scene: its index.
enum class GeometryId : std::uint32_t {};

constexpr std::uint32_t index(BodyId id)
{
    return id.slot;
}
constexpr std::uint32_t index(ModelId id)
{
    return id.slot;
}
constexpr std::uint32_t index(GeometryId id)
{
    return static_cast<std::uint32_t>(id);
}

} // namespace oncollide

template <>
struct std::hash<oncollide::BodyId> {
    std::size_t operator()(oncollide::BodyId id) const noexcept
    {
        return std::hash<std::uint64_t>()(std::uint64_t(id.generation) << 32 | id.slot);
    }
};
template <>
struct std::hash<oncollide::ModelId> {
    std::size_t operator()(oncollide::ModelId id) const noexcept
    {
        return std::hash<std::uint64_t>()(std::uint64_t(id.generation) << 32 | id.slot);
    }
};
