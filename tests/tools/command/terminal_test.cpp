// The command's output: on a terminal and off it, its log, and the references generated from its options.
#include "tools/command_fixture.hpp"

#include <pty.h>

namespace oncollide::test {
namespace {

class Terminal : public CommandLine {
protected:
    /// The command's output on a terminal of 80 columns.
    std::string on_terminal(const std::vector<std::string>& arguments, const char* no_colour = "")
    {
        const winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
        int terminal = -1;
        const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
        if (child == 0) {
            ::setenv("TERM", "xterm", 1), ::setenv("NO_COLOR", no_colour, 1), ::setenv("ONCOLLIDE_DATA", "", 1);
            std::vector<char*> argv{const_cast<char*>("oncollide")};
            for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
            argv.push_back(nullptr);
            if (::chdir(folder_.path().c_str()) == 0) ::execv(ONCOLLIDE_COMMAND, argv.data());
            ::_exit(127);
        }
        std::string text;
        char bytes[4096];
        for (ssize_t n; (n = ::read(terminal, bytes, sizeof bytes)) > 0;) text.append(bytes, std::size_t(n));
        ::close(terminal);
        int status = 0;
        ::waitpid(child, &status, 0);
        return text;
    }

    static std::size_t longest_line(const std::string& text)
    {
        std::size_t longest = 0;
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);)
            if (!line.starts_with("  oncollide")) longest = std::max(longest, line.size()); // examples are not wrapped
        return longest;
    }
};

TEST_F(Terminal, ColoursAreForTerminalsAlone)
{
    write_cube("cube.off");
    const std::string red = "\033[31m";
    EXPECT_NE(on_terminal({"run", "nowhere"}).find(red + "oncollide:\033[0m no scene"), std::string::npos);
    EXPECT_NE(on_terminal({"check", "cube.off", "cube.off"}).find(red + "colliding\033[0m"), std::string::npos);
    EXPECT_EQ(on_terminal({"run", "nowhere"}, "1").find(red), std::string::npos) << "NO_COLOR";
    EXPECT_EQ(run({"run", "nowhere"}).err.find('\033'), std::string::npos);
    EXPECT_EQ(run({"check", "cube.off", "cube.off"}).out.find('\033'), std::string::npos);
}

TEST_F(Terminal, ALongRunShowsHowFarItIsAndWhatIsLeft)
{
    const std::string shown = on_terminal({"run", "many", "--bodies", "400", "--frames", "1000", "--exact", "on"});
    const std::size_t line = shown.find("frame: ");
    ASSERT_NE(line, std::string::npos) << shown;
    EXPECT_NE(shown.find(" of 1000, ", line), std::string::npos) << shown;
    EXPECT_NE(shown.find(" left", line), std::string::npos) << shown;
    EXPECT_EQ(on_terminal({"run", "many", "--bodies", "400", "--frames", "20", "--quiet"}), "");
}

TEST_F(Terminal, HelpFitsTheTerminal)
{
    for (const char* command : {"run", "check", "render", "clash", "spheres", "accuracy"}) {
        EXPECT_LE(longest_line(on_terminal({command, "--help"}, "1")), 80u + 1) << command; // one more for the carriage
                                                                                            // return
        EXPECT_LE(longest_line(run({command, "--help"}).out), 100u) << command;
    }
    const std::string help = run({"run", "--help"}).out;
    for (const char* word : {"Usage: oncollide run [OPTIONS] scene", "\nAccuracy:\n", "\nResults:\n", "--kinds"})
        EXPECT_NE(help.find(word), std::string::npos) << word << "\n" << help;
}

TEST_F(Terminal, TheLogSaysAsMuchAsItsVariable)
{
    const auto said = [&](const char* level, const char* scene = "many") {
        return run({"run", scene, "--bodies", "20", "--frames", "2", "--quiet"},
                   {.folder = {}, .environment = {{"ONCOLLIDE_LOG", level}}});
    };
    EXPECT_EQ(said("").err, "");
    EXPECT_EQ(said("error").err, "");
    EXPECT_NE(said("info").err.find("oncollide: info: "), std::string::npos);
    EXPECT_NE(said("info").err.find("20 bodies"), std::string::npos);
    EXPECT_EQ(said("info").err.find("frame 1:"), std::string::npos);
    EXPECT_NE(said("debug").err.find("frame 1:"), std::string::npos);
    EXPECT_EQ(said("debug").out, "") << "results are not mixed with the log";
    EXPECT_EQ(said("error", "nowhere").code, 64);
    EXPECT_NE(said("error", "nowhere").err.find("no scene named"), std::string::npos) << "errors are always printed";
    const Outcome wrong = said("inof");
    EXPECT_EQ(wrong.code, 64);
    EXPECT_NE(wrong.err.find("ONCOLLIDE_LOG: unknown level 'inof'; did you mean 'info'?"), std::string::npos)
        << wrong.err;
}

TEST_F(Terminal, TheReferencesHaveEveryCommandAndOption)
{
    const std::string markdown = run({"reference", "markdown"}).out, bash = run({"reference", "bash"}).out;
    const std::string zsh = run({"reference", "zsh"}).out, fish = run({"reference", "fish"}).out;
    ASSERT_EQ(run({"reference", "man", "--out", "."}).code, 0);
    for (const char* command : {"run", "check", "accuracy study", "clash"}) {
        EXPECT_NE(markdown.find(fmt::format("\n## oncollide {}\n", command)), std::string::npos) << command;
        for (const std::string* shell : {&bash, &zsh, &fish})
            EXPECT_NE(shell->find(fmt::format("oncollide {}", command)), std::string::npos) << command;
    }
    EXPECT_NE(markdown.find("`--exact auto\\|on\\|off\\|predicates\\|fcl`"), std::string::npos) << markdown;
    const std::string page = folder_.read("oncollide-run.1");
    EXPECT_TRUE(page.starts_with(".TH ONCOLLIDE\\-RUN 1 ")) << page;
    EXPECT_NE(page.find("\\-\\-max\\-error M"), std::string::npos);
    EXPECT_GT(folder_.read("oncollide-accuracy-study.1").size(), 500u);
    EXPECT_EQ(run({"--help"}).out.find("reference"), std::string::npos) << "it is only for builds";
    expect_error(64, {"reference", "tcsh"}, {"'tcsh'", "bash"});
}

TEST_F(Terminal, BashCompletesCommandsOptionsAndValues)
{
    folder_.write("oncollide.bash", run({"reference", "bash"}).out);
    folder_.write("part.obj", "");
    const auto complete = [&](const std::string& words) { // the last word is the one that is completed
        const Outcome outcome =
            run_program("/bin/bash",
                        {"-c", "source oncollide.bash; COMP_WORDS=(" + words +
                                   "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _oncollide; echo \" ${COMPREPLY[@]} \""},
                        {.folder = folder_.path()});
        EXPECT_EQ(outcome.err, "");
        return outcome.out;
    };
    EXPECT_EQ(complete("oncollide cl"), " clash \n");
    EXPECT_EQ(complete("oncollide accuracy stu"), " study \n");
    EXPECT_EQ(complete("oncollide run --exac"), " --exact \n");
    EXPECT_EQ(complete("oncollide run --exact pre"), " predicates \n");
    EXPECT_EQ(complete("oncollide run ci"), " city \n");
    EXPECT_EQ(complete("oncollide check par"), " part.obj \n");
    EXPECT_EQ(complete("oncollide check part.obj --pose-a x --dist"), " --distance \n");
    EXPECT_EQ(complete("oncollide run --threads ''"), "  \n");
}

TEST_F(Terminal, BothWordsOfAnOptionMeanTheSame)
{
    const auto hash = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments{"run", "many", "--bodies", "60", "--frames", "2", "--quiet", "--json", "-"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out).at("header").at("hash");
    };
    EXPECT_EQ(hash({"--exact", "on", "--contact-kinds"}), hash({"--exact", "predicates", "--kinds"}));
    EXPECT_EQ(hash({"--exact", "auto"}), hash({"--exact", "on"}));
    EXPECT_NE(hash({"--exact", "off", "--skip", "refine"}), hash({"--exact", "off"}));
}

} // namespace
} // namespace oncollide::test
