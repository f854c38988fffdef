// Results in HDF5, frame by frame: run --pairs and --from-frame.
#include "tools/command_fixture.hpp"

#include <charconv>
#include <optional>
#include <thread>

namespace oncollide::test {
namespace {

class Pairs : public CommandLine {
protected:
    void SetUp() override
    {
        if (!can_write_hdf5()) GTEST_SKIP() << "skipped: no HDF5";
    }
    bool can_write_hdf5()
    {
        static const bool can =
            run({"run", "city", "--bodies", "5", "--frames", "1", "--quiet", "--pairs", "try.h5"}).code == 0;
        std::filesystem::remove(folder_ / "try.h5");
        return can;
    }

    std::vector<std::string> city(int frames, std::vector<std::string> more)
    {
        std::vector<std::string> arguments{
            "run",    "city", "--bodies", "60",         "--frames", std::to_string(frames),
            "--seed", "3",    "--exact",  "predicates", "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    /// Hash of all frames, from the JSON report; an empty text if the run fails.
    std::string hash_of(std::vector<std::string> arguments)
    {
        arguments.insert(arguments.end(), {"--json", "hash.json"});
        const Outcome outcome = run(std::move(arguments));
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.code ? "" : read_json("hash.json").at("header").at("hash").get<std::string>();
    }
    /// The number of frames in a file, counted from frame 0: a run that continues too late reports it. -1: unreadable.
    int frames_of(const std::string& file)
    {
        const Outcome outcome = run(city(1'000'001, {"--pairs", file, "--from-frame", "1000000"}));
        constexpr std::string_view before = "holds frames 0 to ";
        const std::size_t at = outcome.err.find(before);
        int last = -1;
        if (at != std::string::npos)
            std::from_chars(outcome.err.data() + at + before.size(), outcome.err.data() + outcome.err.size(), last);
        EXPECT_EQ(outcome.code, last < 0 ? 65 : 64) << outcome.err;
        if (last < 0 && outcome.err.find("cut off before the first frame") == std::string::npos)
            return ADD_FAILURE() << outcome.err, -1;
        return last + 1;
    }
    /// Waits until a file that is being written has room for more pairs than one chunk holds: earlier frames are then
    /// complete.
    void wait_for_frames(const std::string& file)
    {
        const auto ripe = [&] {
            std::error_code none;
            return std::filesystem::file_size(folder_ / file, none) > 1'200'000 && !none;
        };
        for (int k = 0; k < 6000 && !ripe(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_TRUE(ripe());
    }
    /// Runs a Python program that uses h5py; empty if h5py is missing.
    std::optional<std::string> python(const std::string& program)
    {
        Surroundings around{.folder = folder_.path()};
        for (const char* interpreter :
             {"python3", "/usr/bin/python3"}) { // the first one may be a virtual environment's
            const auto with = [&](const std::string& rest) {
                return run_program("/bin/sh", {"-c", interpreter + rest}, around);
            };
            if (with(" -c 'import h5py, pandas'").code != 0) continue;
            folder_.write("program.py", program);
            const Outcome outcome = with(" program.py");
            EXPECT_EQ(outcome.code, 0) << outcome.err;
            return outcome.out;
        }
        return std::nullopt;
    }
};

TEST_F(Pairs, AreThoseOfTheCsvFile)
{
    ASSERT_EQ(run(city(4, {"--separate", "--csv", "p.csv", "--pairs", "p.h5"})).code, 0);
    const auto same = python(R"(
import h5py, pandas
with h5py.File("p.h5", "r") as file:
    pairs, names = pandas.DataFrame(file["pairs"][:]), file["names"].asstr()[:]
    for column in "verdict", "stage", "kind":
        words = {v: k for k, v in h5py.check_enum_dtype(file["pairs"].dtype[column]).items()}
        pairs[column] = pairs[column].map(words)
    frames = file["frames"][:]
    pairs.insert(0, "frame", frames["frame"].repeat(frames["pairs"].astype("i8")))
    assert (frames["first"] == frames["pairs"].cumsum() - frames["pairs"]).all()
    assert file.attrs["scene"] == "city" and file.attrs["bodies"] == 60
pairs["a"], pairs["b"] = names[pairs["a"]], names[pairs["b"]]
csv = pandas.read_csv("p.csv", float_precision="round_trip")
assert len(csv) > 20 and (csv["frame"] == pairs["frame"]).all()
for column in "a", "b", "verdict", "stage": assert (csv[column] == pairs[column]).all(), column
assert (csv["kind"].fillna("unknown") == pairs["kind"]).all()
for column in "gap_bound", "max_error": assert (csv[column].fillna(float("inf")) == pairs[column]).all(), column
print("same")
)");
    if (same) {
        EXPECT_EQ(*same, "same\n");
    }
}

TEST_F(Pairs, SweepsStandBesideThePairs)
{
    ASSERT_EQ(run(city(5, {"--pace", "20", "--continuous", "--separate", "--csv", "p.csv", "--pairs", "p.h5"})).code,
              0);
    const auto same = python(R"(
import h5py, pandas
with h5py.File("p.h5", "r") as file:
    pairs, sweeps = pandas.DataFrame(file["pairs"][:]), pandas.DataFrame(file["sweeps"][:])
csv = pandas.read_csv("p.csv", float_precision="round_trip")
assert len(csv) == len(pairs) == len(sweeps)
assert csv["contact_by"].notna().sum() > 5 and csv["clear_until"].isna().sum() > 0
for column in "clear_until", "x", "y", "z", "normal_x", "normal_y", "normal_z":
    assert (csv[column].fillna(-9) == sweeps[column].fillna(-9)).all(), column
for column in "contact_by", "gap":
    assert (csv[column].fillna(9e9) == sweeps[column].replace(float("inf"), 9e9).fillna(9e9)).all(), column
assert (csv["separating"].fillna(0) == sweeps["separating"]).all()
none = 2**32 - 1
for side in "a", "b":
    triangles = sweeps["triangle_" + side]
    known = triangles != none
    assert (csv["part_" + side][known].astype(float) == triangles[known]).all(), side
    assert not (csv["part_" + side].isna() & known).any(), side
print("same")
)");
    if (same) {
        EXPECT_EQ(*same, "same\n");
    }
}

TEST_F(Pairs, AContinuousRunGoesOnToTheSameHash)
{
    const std::vector<std::string> fast{"--pace", "20", "--continuous", "--pairs"};
    const auto with = [&](int frames, std::vector<std::string> more) {
        more.insert(more.begin(), fast.begin(), fast.end());
        return city(frames, std::move(more));
    };
    const std::string whole = hash_of(with(6, {"whole.h5"}));
    ASSERT_EQ(run(with(4, {"p.h5"})).code, 0);
    EXPECT_EQ(hash_of(with(6, {"p.h5", "--from-frame", "3"})), whole);
    EXPECT_EQ(folder_.read("p.h5").size(), folder_.read("whole.h5").size());
    expect_error(64, city(6, {"--pace", "20", "--pairs", "p.h5", "--from-frame", "3"}),
                 {"p.h5", "its 'settings' differs from this run's", "continuous"});
}

TEST_F(Pairs, AreReadByTheProgramOfTheManual)
{
    ASSERT_EQ(run(city(4, {"--pairs", "out.h5"})).code, 0);
    std::ifstream in(ONCOLLIDE_SOURCE_DIR "/docs/results.md");
    const std::string page(std::istreambuf_iterator<char>(in), {});
    const std::size_t begin = page.find("```python\n"), end = page.find("```\n", begin + 10);
    ASSERT_NE(end, std::string::npos);
    if (const auto shown = python(page.substr(begin + 10, end - begin - 10))) {
        EXPECT_NE(shown->find("colliding"), std::string::npos) << *shown;
    }
}

TEST_F(Pairs, GoOnFromAnyFrameToTheSameHash)
{
    const std::string whole = hash_of(city(6, {"--pairs", "whole.h5"}));
    for (const char* from : {"1", "3", "6"}) {
        ASSERT_EQ(run(city(*from == '6' ? 6 : 5, {"--pairs", "p.h5"})).code, 0);
        if (*from != '6') {
            EXPECT_EQ(hash_of(city(6, {"--pairs", "p.h5", "--from-frame", from})), whole) << from;
        }
        EXPECT_EQ(frames_of("p.h5"), 6);
        EXPECT_EQ(folder_.read("p.h5").size(), folder_.read("whole.h5").size());
    }
    EXPECT_NE(hash_of(city(6, {"--from-frame", "3"})), whole) << "of other frames";
    ASSERT_EQ(run(city(6, {"--pairs", "late.h5", "--from-frame", "3"})).code, 0) << "there is no file";
    EXPECT_NE(run(city(9, {"--pairs", "late.h5", "--from-frame", "8"})).err.find("holds frames 3 to 5"),
              std::string::npos);
}

TEST_F(Pairs, AreWholeFramesAfterAKill)
{
    for (int round = 0; round < 3; ++round) {
        Surroundings around;
        around.meanwhile = [&](pid_t child) {
            wait_for_frames("p.h5");
            std::this_thread::sleep_for(std::chrono::milliseconds(7 * round));
            ::kill(child, SIGKILL);
        };
        ASSERT_EQ(run(city(100'000'000, {"--pairs", "p.h5"}), around).code, 1000 + SIGKILL);
        const int frames = frames_of("p.h5");
        ASSERT_GT(frames, 0);
        EXPECT_EQ(hash_of(city(frames + 5, {"--pairs", "p.h5", "--from-frame", std::to_string(frames)})),
                  hash_of(city(frames + 5, {})))
            << frames;
        EXPECT_EQ(frames_of("p.h5"), frames + 5);
        std::filesystem::remove(folder_ / "p.h5");
    }
}

TEST_F(Pairs, AreClosedWhenTheRunIsInterrupted)
{
    Surroundings around;
    around.meanwhile = [&](pid_t child) {
        wait_for_frames("p.h5");
        ::kill(child, SIGINT);
    };
    EXPECT_EQ(run(city(100'000'000, {"--pairs", "p.h5"}), around).code, 130);
    EXPECT_GT(frames_of("p.h5"), 0);
    const auto shown = python("import h5py\nprint(len(h5py.File('p.h5', 'r')['frames']) > 0)\n");
    if (shown) {
        EXPECT_EQ(*shown, "True\n") << "a finished file needs no SWMR reader";
    }
}

TEST_F(Pairs, KeepWholeFramesWhenTheDiskIsFull)
{
    const Outcome outcome =
        run_program("/bin/sh",
                    {"-c", std::string("ulimit -f 2000; exec ") + ONCOLLIDE_COMMAND +
                               " run city --bodies 60 --seed 3 --exact predicates --frames 1000000 --separate --quiet"
                               " --pairs p.h5"},
                    {.folder = folder_.path(), .environment = {{"ONCOLLIDE_DATA", ""}}});
    EXPECT_EQ(outcome.code, 73);
    EXPECT_EQ(outcome.err, "oncollide: p.h5: cannot write: File too large\n");
    const Outcome late = run(city(1'000'001, {"--separate", "--pairs", "p.h5", "--from-frame", "1000000"}));
    EXPECT_NE(late.err.find("holds frames 0 to "), std::string::npos) << late.err;
}

TEST_F(Pairs, AreRefusedWhereTheyCannotBeWrittenOrContinued)
{
    ASSERT_EQ(run(city(3, {"--pairs", "p.h5"})).code, 0);
    expect_error(64, city(3, {"--pairs", "-"}), {"--pairs -", "needs a file"});
    expect_error(73, city(3, {"--pairs", "no/p.h5"}), {"no/p.h5"});
    expect_error(64, city(3, {"--pairs", "x", "--csv", "x"}), {"both go to 'x'"});
    expect_error(64, city(3, {"--from-frame", "3"}), {"--from-frame 3", "0 to 2"});
    expect_error(64, city(3, {"--from-frame", "-1"}), {"--from-frame -1", "at least 0"});
    expect_error(64, city(9, {"--pairs", "p.h5", "--from-frame", "5"}), {"p.h5", "holds frames 0 to 2", "1 to 3"});
    expect_error(64, city(9, {"--pairs", "p.h5", "--from-frame", "2", "--clearance", "1"}),
                 {"p.h5", "its 'settings' differs from this run's", "clearance"});
    expect_error(64, {"run", "hills", "--bodies", "5", "--frames", "9", "--pairs", "p.h5", "--from-frame", "2"},
                 {"p.h5", "its 'scene' differs from this run's: city there, hills here"});
    EXPECT_EQ(frames_of("p.h5"), 3) << "a file that cannot be continued is kept";
    folder_.write("p.h5", "nothing of the kind");
    expect_error(65, city(9, {"--pairs", "p.h5", "--from-frame", "2"}), {"p.h5", "not a results file"});
    EXPECT_EQ(folder_.read("p.h5"), "nothing of the kind");
    EXPECT_EQ(folder_.list(), std::vector<std::string>{"p.h5"});
}

/// A killed run leaves an empty file, half a header or no frame. Each gets the same code and the same cure.
TEST_F(Pairs, OfARunThatWasKilledBeforeItsFirstFrameAreRefusedAlike)
{
    ASSERT_EQ(run(city(1, {"--pairs", "p.h5"})).code, 0);
    const std::string whole = folder_.read("p.h5");
    std::vector<std::string> left{"", whole.substr(0, 8), whole.substr(0, 100), whole.substr(0, 1000)};
    if (const auto done = python(R"(
import h5py
with h5py.File("p.h5", "r") as file, h5py.File("no_frame.h5", "w", libver="latest") as copy:
    for name, value in file.attrs.items(): copy.attrs[name] = value
    for name in file:
        if name == "names": file.copy(name, copy)
        else: copy.create_dataset(name, (0,), file[name].dtype, maxshape=(None,), chunks=(100,))
)"))
        left.push_back(folder_.read("no_frame.h5"));
    for (const std::string& bytes : left) {
        folder_.write("p.h5", bytes);
        const std::vector<std::string> words{"p.h5", "cut off before the first frame", "run the scene again"};
        expect_error(65, {"view", "p.h5", "-o", "page.html"}, words);
        expect_error(65, city(9, {"--pairs", "p.h5", "--from-frame", "1"}), words);
    }
}

} // namespace
} // namespace oncollide::test
