#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace oncollide {

/// A body of a World, as World::add_body() returned it. `BodyId{}` is null. The World refuses an id that is null, stale
/// (its body was removed) or foreign (another World issued it).
struct alignas(8) BodyId {
    std::uint32_t slot = 0;       ///< row in the World's columns; free slots are reused
    std::uint16_t generation = 0; ///< numbers the bodies that the slot has held, from 1; 0: null
    std::uint16_t world = 0;      ///< tag of the World that issued the id

    constexpr explicit operator bool() const { return generation != 0; }
    friend constexpr auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// A model of a World, as World::add() returned it; in the same form as BodyId.
struct alignas(8) ModelId {
    std::uint32_t slot = 0;
    std::uint16_t generation = 0;
    std::uint16_t world = 0;

    constexpr explicit operator bool() const { return generation != 0; }
    friend constexpr auto operator<=>(const ModelId&, const ModelId&) = default;
};

/// The slot of an id with this generation is not reused.
constexpr std::uint16_t last_generation = 0xffff;

/// A body of a Scene: its index. A Scene never removes bodies.
enum class SceneBodyId : std::uint32_t {};
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
constexpr std::uint32_t index(SceneBodyId id)
{
    return static_cast<std::uint32_t>(id);
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
        return std::hash<std::uint64_t>()(std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot);
    }
};
template <>
struct std::hash<oncollide::ModelId> {
    std::size_t operator()(oncollide::ModelId id) const noexcept
    {
        return std::hash<std::uint64_t>()(std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot);
    }
};
