#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace oncollide::test {

/// A picture as rows of red, green and blue.
struct Decoded {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;

    const std::uint8_t* at(int x, int y) const { return &pixels[std::size_t(3 * (y * width + x))]; }
    /// Number of pixels in the columns from..to that are `wanted`.
    template <class Wanted>
    int count(Wanted wanted, int from = 0, int to = -1) const
    {
        int count = 0;
        for (int y = 0; y < height; ++y)
            for (int x = from; x < (to < 0 ? width : to); ++x) count += wanted(at(x, y));
        return count;
    }
};

/// Fails the test if `file` is not a PNG file.
inline Decoded decode(const std::string& file)
{
    EXPECT_TRUE(file.starts_with("\x89PNG\r\n\x1a\n"));
    Decoded image;
    int channels = 0;
    stbi_uc* pixels = stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(file.data()), int(file.size()),
                                            &image.width, &image.height, &channels, 3);
    if (!pixels) {
        ADD_FAILURE() << "not a readable PNG file";
        return image;
    }
    image.pixels.assign(pixels, pixels + 3 * image.width * image.height);
    stbi_image_free(pixels);
    return image;
}

} // namespace oncollide::test
