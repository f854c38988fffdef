#pragma once
#include "tools/browser.hpp"
#include "tools/decoded_png.hpp"
#include "tools/view_fixture.hpp"

namespace oncollide::test {

/// Red, as collisions are drawn.
inline bool is_colliding(const std::uint8_t* p)
{
    return p[0] > 150 && p[0] > 2 * p[1] && p[0] > 2 * p[2];
}
inline bool is_blue(const std::uint8_t* p)
{
    return p[2] > 120 && p[2] > p[0] + 40;
}

/// Pages with three.js in Chromium, on a software renderer. Skipped if either is missing.
template <class Fixture>
class InBrowser : public Fixture {
protected:
    using Fixture::folder_;

    void SetUp() override
    {
        Fixture::SetUp();
        if (!std::filesystem::exists(chromium)) GTEST_SKIP() << "needs Debian's package chromium";
        if (!std::filesystem::exists(three)) GTEST_SKIP() << "needs Debian's package libjs-three";
    }

    struct Seen {
        std::string document; ///< at the end
        Decoded picture;

        /// data-NAME of the document.
        std::string data(const std::string& name) const
        {
            const std::string mark = "data-" + name + "=\"";
            const std::size_t from = document.find(mark);
            if (from == std::string::npos || from > document.find("<head>")) return "";
            return document.substr(from + mark.size(), document.find('"', from + mark.size()) - from - mark.size());
        }
    };
    /// The page after the given time of the browser's clock. The browser may draw late on a loaded machine, so a
    /// picture without bodies, whose labels may be there, is taken again.
    Seen look(const std::string& page, const std::string& fragment, const std::string& size = "900,640",
              int milliseconds = 1500)
    {
        const Seen seen = look_once(page, fragment, size, milliseconds);
        const bool early = (seen.data("drawn").empty() || drawn(seen.picture) < 200) && milliseconds < 10'000;
        return early ? look(page, fragment, size, 3 * milliseconds) : seen;
    }
    Seen look_once(const std::string& page, const std::string& fragment, const std::string& size, int milliseconds)
    {
        const Outcome outcome = browse(
            folder_, {"--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                      "--disable-dev-shm-usage", "--enable-logging=stderr", "--run-all-compositor-stages-before-draw",
                      fmt::format("--virtual-time-budget={}", milliseconds), "--window-size=" + size,
                      "--screenshot=" + (folder_ / "x.png").string(), "--dump-dom",
                      "file://" + (folder_ / page).string() + "#" + fragment});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("Uncaught"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("THREE."), std::string::npos) << outcome.err; // no shader fails to compile
        Seen seen{outcome.out, decode(folder_.read("x.png"))};
        EXPECT_EQ(seen.data("ready"), "yes") << fragment << "\n" << outcome.err;
        EXPECT_EQ(seen.data("error"), "");
        return seen;
    }
    /// Pixels of the scene that are `wanted`: outside the panel, the legend and the strip of frames.
    template <class Wanted>
    static int in_scene(const Decoded& picture, Wanted wanted)
    {
        int count = 0;
        for (int y = 60; y < 420; ++y)
            for (int x = 0; x < 520; ++x) count += wanted(picture.at(x, y));
        return count;
    }
    /// Pixels that differ from the background.
    static int drawn(const Decoded& picture)
    {
        const std::uint8_t* paper = picture.at(260, 4);
        return in_scene(picture, [&](const std::uint8_t* p) {
            return std::abs(p[0] - paper[0]) + std::abs(p[1] - paper[1]) + std::abs(p[2] - paper[2]) > 60;
        });
    }
};

} // namespace oncollide::test
