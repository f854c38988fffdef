// Files that another program turns into glTF: 'oncollide-cad' and 'oncollide-ifc', here in the form of small scripts.
#include <thread>

#include "tools/command/clash/clash_fixture.hpp"

namespace oncollide::test {
namespace {

namespace fs = std::filesystem;

class ConvertedFiles : public ClashCommand {
protected:
    ConvertedFiles()
    {
        folder_.write("part.step", "ISO-10303-21;");
        // Two tetrahedra of 1 m that overlap, and the name and the deflection of each.
        folder_.write("two.gltf", R"({"asset":{"version":"2.0"},"nodes":[{"name":"top","children":[1,2]},
            {"name":"a","mesh":0,"extras":{"deflection":1e-4}},{"name":"b","mesh":0,"translation":[0.5,0,0]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":12,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":144}],"buffers":[{"byteLength":144,"uri":"corners.bin"}]})");
        const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        std::string bytes;
        for (const int corner : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
            bytes.append(reinterpret_cast<const char*>(corners[corner]), 12);
        folder_.write("corners.bin", bytes);
    }
    static Surroundings with(std::vector<std::pair<std::string, std::string>> environment)
    {
        Surroundings around;
        around.environment = std::move(environment);
        return around;
    }
    /// Runs the command with a shell script as oncollide-cad.
    Outcome run_with(const std::string& script, std::vector<std::string> arguments, Surroundings around = {})
    {
        around.environment.emplace_back("ONCOLLIDE_CAD", write_script("cad", script).string());
        return run(std::move(arguments), std::move(around));
    }
    fs::path write_script(const std::string& name, const std::string& script)
    {
        const fs::path file = folder_.write(name, "#!/bin/sh\n" + script + "\n");
        fs::permissions(file, fs::perms::owner_all);
        return file;
    }
    /// Expects an error of that code, which names the file and has the words.
    void expect_fault(int code, const std::string& script, const std::string& words)
    {
        SCOPED_TRACE(script);
        const Outcome outcome = run_with(script, {"clash", "part.step"});
        EXPECT_EQ(outcome.code, code);
        EXPECT_EQ(outcome.out, "");
        EXPECT_TRUE(outcome.err.starts_with("oncollide: part.step: " + words)) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    }
};

TEST_F(ConvertedFiles, AreAssemblies)
{
    const Outcome outcome = run_with("cp two.gltf $3; echo warning: $1: a curve was left out >&2; echo chatter",
                                     {"clash", "part.step", "-o", "out.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(outcome.err, "oncollide: warning: part.step: a curve was left out\n");
    EXPECT_EQ(pairs("out.json"), Pairs{"a b crossing new"});
    EXPECT_EQ(read_json("out.json")["clashes"][0]["a"]["file"], "part.step");
    EXPECT_EQ(read_json("out.json")["clashes"][0]["where"][0], 750.0) << "millimetres of a file in metres";
}

TEST_F(ConvertedFiles, AreReadByOtherCommands)
{
    folder_.write("two.step", "x");
    EXPECT_EQ(run_with("cp two.gltf $3", {"check", "part.step", "two.step"}).code, 1);
    EXPECT_EQ(run_with("cp two.gltf $3", {"scene", "part.step", "--out", "s.json"}).code, 0);
    EXPECT_EQ(read_json("s.json")["bodies"].size(), 2u);
    EXPECT_EQ(run_with("cp two.gltf $3", {"cook", "part.step", "-o", "part.cooked"}).code, 0);
}

TEST_F(ConvertedFiles, AreNotFoundInACacheThatDoesNotKnowTheirDeflection)
{
    const Outcome outcome =
        run_with("cp two.gltf $3; echo called >>calls", {"check", "part.step", "part.step", "--cache", "cache"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_TRUE(fs::is_empty(folder_ / "cache"));
}

TEST_F(ConvertedFiles, HaveNamesThatNeedNoShell)
{
    folder_.write("-o $(touch x) '.step", "x");
    const Outcome outcome = run_with("test -f \"$1\" && cp two.gltf $3", {"clash", "./-o $(touch x) '.step"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(ConvertedFiles, OfAFaultyConverterAreOneErrorThatNamesTheFile)
{
    expect_fault(65, "echo starting; echo oncollide-cad: error: $1: it holds no shape >&2; exit 65",
                 "it holds no shape\n");
    expect_fault(66, "echo error: no licence; exit 66", "no licence\n");
    expect_fault(65, "kill -SEGV $$", "oncollide-cad crashed (Segmentation fault)");
    expect_fault(65, "kill -KILL $$", "oncollide-cad was killed; the system may lack memory");
    expect_fault(65, "exit 9", "oncollide-cad failed (exit code 9)");
    expect_fault(65, "exit 0", "oncollide-cad wrote no mesh");
    expect_fault(65, "echo text >$3", "");
    expect_fault(65, "printf glTF >$3", "");
}

TEST_F(ConvertedFiles, WithoutTheirConverterSayWhatToInstall)
{
    folder_.write("house.ifc", "ISO-10303-21;");
    const Surroundings nothing = with({{"ONCOLLIDE_IFC", ""}, {"PATH", ""}});
    const Outcome ifc = run({"clash", "house.ifc"}, nothing);
    if (ifc.err.find("is not installed") != ifc.err.npos) { // else it lies beside the command
        EXPECT_EQ(ifc.code, 66);
        EXPECT_NE(ifc.err.find("house.ifc: IFC files are read by oncollide-ifc"), ifc.err.npos) << ifc.err;
        EXPECT_NE(ifc.err.find("glTF"), ifc.err.npos) << ifc.err;
    }
    const Outcome absent = run({"clash", "part.step"}, with({{"ONCOLLIDE_CAD", "no/such"}}));
    EXPECT_EQ(absent.code, 66);
    EXPECT_NE(absent.err.find("ONCOLLIDE_CAD=no/such: not a program"), absent.err.npos) << absent.err;
    const Outcome halted = run_with("", {"clash", "none.step"});
    EXPECT_EQ(halted.code, 66);
    EXPECT_NE(halted.err.find("none.step: no such file"), halted.err.npos) << halted.err;
    folder_.write("cad", "#!/no/such/interpreter\n");
    const Outcome unusable = run({"clash", "part.step"}, with({{"ONCOLLIDE_CAD", (folder_ / "cad").string()}}));
    EXPECT_EQ(unusable.code, 66);
    EXPECT_NE(unusable.err.find("part.step: oncollide-cad cannot be started"), unusable.err.npos) << unusable.err;
}

TEST_F(ConvertedFiles, AreFoundInTheFoldersOfPath)
{
    fs::create_directory(folder_ / "programs");
    write_script("programs/oncollide-ifc", "cp two.gltf $3");
    folder_.write("house.ifc", "ISO-10303-21;");
    Surroundings path = with({{"ONCOLLIDE_IFC", ""}, {"PATH", (folder_ / "programs").string() + ":/bin:/usr/bin"}});
    path.folder = folder_.path();
    fs::copy_file(ONCOLLIDE_COMMAND, folder_ / "oncollide"); // beside the built command lies a real converter
    EXPECT_EQ(run_program((folder_ / "oncollide").string(), {"clash", "house.ifc"}, path).code, 1);
}

TEST_F(ConvertedFiles, AreUsableOrNotInTheDoctorsWords)
{
    const auto doctor = [&](const std::string& script) {
        write_script("ifc", script);
        const Outcome outcome = run({"doctor"}, with({{"ONCOLLIDE_IFC", (folder_ / "ifc").string()}}));
        const std::size_t at = outcome.out.find("oncollide-ifc ");
        return outcome.out.substr(at, outcome.out.find('\n', at) - at);
    };
    const std::string program = (folder_ / "ifc").string();
    EXPECT_EQ(doctor("echo parser 1.2"), "oncollide-ifc IFC files, by " + program + " (parser 1.2)");
    EXPECT_EQ(doctor("echo 'oncollide-ifc: error: IFC needs Node.js' >&2; exit 66"),
              "oncollide-ifc IFC files, not usable by " + program + ": IFC needs Node.js");
    EXPECT_EQ(doctor("exit 3"), "oncollide-ifc IFC files, not usable by " + program + ": it does not start");
}

TEST_F(ConvertedFiles, LeaveNoConverterBehindWhenTheCommandIsEnded)
{
    Surroundings around;
    around.meanwhile = [this](pid_t command) {
        while (!fs::exists(folder_ / "pid")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ::kill(command, SIGTERM);
    };
    const Outcome outcome = run_with("echo $$ >tmp; mv tmp pid; exec sleep 1000", {"clash", "part.step"}, around);
    EXPECT_EQ(outcome.code, 1000 + SIGTERM);
    const fs::path converter = fs::path("/proc") / std::to_string(std::stoi(folder_.read("pid"))) / "cmdline";
    std::string line = "sleep";
    for (int wait = 0; wait < 10'000 && !line.empty(); ++wait) { // empty, too, for a process that nobody waits for
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::ifstream file(converter);
        line = {std::istreambuf_iterator<char>(file), {}};
    }
    EXPECT_EQ(line, "") << "it still runs";
}

} // namespace
} // namespace oncollide::test
