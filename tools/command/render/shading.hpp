#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include <oncollide/narrowphase/gl/picture.hpp>

namespace oncollide::tools {

constexpr Colour touching{214, 40, 40};

/// Distinguishable hues, none near red, all of similar lightness.
constexpr Colour colour_of(std::uint32_t body)
{
    constexpr std::array<Colour, 8> palette{{{104, 152, 196},
                                             {222, 184, 108},
                                             {126, 178, 122},
                                             {170, 140, 196},
                                             {98, 178, 178},
                                             {196, 160, 132},
                                             {150, 160, 176},
                                             {186, 192, 104}}};
    return palette[body % palette.size()];
}

/// The colour of a body's surface, paler than its spheres, which lie on it.
constexpr Colour surface_colour(std::uint32_t body)
{
    const auto half_white = [](std::uint8_t x) { return static_cast<std::uint8_t>((x + 255) / 2); };
    const Colour c = colour_of(body);
    return {half_white(c.red), half_white(c.green), half_white(c.blue)};
}

/// @param light  share of the colour, 0 to 1
inline Colour lit(Colour colour, double light)
{
    const auto part = [&](std::uint8_t full) { return static_cast<std::uint8_t>(full * light + 0.5); };
    return {part(colour.red), part(colour.green), part(colour.blue)};
}

constexpr int samples_per_side = 2; ///< samples per side of a pixel, for smooth edges
constexpr std::size_t samples_per_pixel = samples_per_side * samples_per_side;

constexpr Colour mean(const std::array<Colour, samples_per_pixel>& samples)
{
    std::array<std::size_t, 3> sum{};
    for (const Colour& c : samples) sum[0] += c.red, sum[1] += c.green, sum[2] += c.blue;
    const auto part = [&](std::size_t k) {
        return static_cast<std::uint8_t>((sum[k] + samples_per_pixel / 2) / samples_per_pixel);
    };
    return {part(0), part(1), part(2)};
}

/// Light on a surface from the camera.
/// @param facing  cosine between the surface's normal and the view, either sign
constexpr double light_of(double facing)
{
    return 0.35 + 0.65 * (facing < 0 ? -facing : facing);
}

} // namespace oncollide::tools
