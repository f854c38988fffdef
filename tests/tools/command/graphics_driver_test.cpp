// A graphics driver that crashes costs the pictures and nothing else.
#include "tools/command/clash/clash_fixture.hpp"

namespace oncollide::test {
namespace {

class CrashingDriver : public ClashCommand {
protected:
    void SetUp() override
    {
        const std::string doctor = run({"doctor"}).out;
        if (doctor.find("GPU 0") == std::string::npos) GTEST_SKIP() << "no OpenGL:\n" << doctor;
        folder_.write("driver.json",
                      fmt::format(R"({{"file_format_version": "1.0.0", "ICD": {{"library_path": "{}"}}}})",
                                  ONCOLLIDE_CRASHING_DRIVER));
        ::setenv("__EGL_VENDOR_LIBRARY_FILENAMES", (folder_ / "driver.json").c_str(), 1);
    }
    void TearDown() override { ::unsetenv("__EGL_VENDOR_LIBRARY_FILENAMES"); }
    static void expect_reason(const std::string& text)
    {
        EXPECT_NE(text.find("the graphics driver crashed (Segmentation fault)"), std::string::npos) << text;
    }
    /// One warning that names the file, and the reason on the page.
    void expect_page_without_pictures(const std::string& file, const Outcome& outcome)
    {
        EXPECT_TRUE(outcome.err.starts_with("oncollide: warning: " + file + ": No pictures: ")) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
        expect_reason(outcome.err), expect_reason(folder_.read(file));
        EXPECT_EQ(folder_.read(file).find("data:image/png"), std::string::npos);
    }
};

TEST_F(CrashingDriver, AClashReportHasEverythingButPictures)
{
    const Outcome outcome = clash({"-o", "x.html", "-o", "x.csv", "-o", "x.json", "--list", "0"});
    EXPECT_EQ(outcome.code, 1) << "there are clashes";
    expect_page_without_pictures("x.html", outcome);
    EXPECT_FALSE(pairs("x.json").empty());
    EXPECT_NE(folder_.read("x.csv").find("crossing"), std::string::npos);
    EXPECT_NE(folder_.read("x.html").find("crossing"), std::string::npos);
    EXPECT_EQ(clash({"-o", "x.html", "--quiet"}).err, "");
    for (const std::string& file : folder_.list()) EXPECT_FALSE(file.ends_with(".part")) << file;
}

TEST_F(CrashingDriver, AStudyHasEverythingButPictures)
{
    folder_.write("near.json", R"({"frames": 1, "geometries": {"ball": {"mesh": {"generate": {"kind": "sphere",
        "radius": 0.5, "triangles": 512}}}}, "bodies": [{"geometry": "ball"}, {"geometry": "ball",
        "position": [0.75, 0.75, 0]}]})"); // apart, and spheres of depth 2 touch
    const Outcome outcome = run({"accuracy", "study", "near.json", "--depths", "2", "--exact", "off", "--warm-up", "0",
                                 "--peers", "none", "--html", "s.html", "--csv", "s.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    expect_page_without_pictures("s.html", outcome);
    EXPECT_NE(folder_.read("s.csv").find("spheres"), std::string::npos);
}

TEST_F(CrashingDriver, RenderHasNoGpu)
{
    expect_error(71, {"render", "city", "--bodies", "5", "--out", "x.png", "--quiet"},
                 {"the graphics driver crashed (Segmentation fault)"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.png"));
    EXPECT_EQ(run({"render", "city", "--bodies", "5", "--out", "x.png", "--quiet", "--rays", "--size", "64x48"}).code,
              0)
        << "needs no driver";
}

TEST_F(CrashingDriver, IsAFindingOfDoctor)
{
    const Outcome outcome = run({"doctor"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    expect_reason(outcome.out);
}

TEST_F(CrashingDriver, WithLimitedMemoryTheBackendIsTriedFirst)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers need terabytes of addresses";
#endif
    const auto limited = [&](const std::string& options) {
        Surroundings around;
        around.folder = folder_.path();
        return run_program("/bin/sh",
                           {"-c", fmt::format("ulimit -v 4000000; exec '{}' run city --bodies 5 --frames 2 --quiet "
                                              "--json r.json {}",
                                              ONCOLLIDE_COMMAND, options)},
                           around);
    };
    const Outcome named = limited("--backend gl-compute");
    EXPECT_EQ(named.code, 71) << named.err;
    expect_reason(named.err);
    EXPECT_NE(named.err.find("memory is limited to 4096 MB"), std::string::npos) << named.err;
    EXPECT_EQ(limited("--backend auto").code, 0);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "r.json"));
}

} // namespace
} // namespace oncollide::test
