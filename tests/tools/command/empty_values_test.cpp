// An empty value, as of an unset variable of the shell, is an error (every_command_test.cpp): of lists, and its words.
#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

using EmptyValues = CommandLine;

TEST_F(EmptyValues, OfAListOrOfAPairAreErrorsToo)
{
    expect_error(64, {"render", "many", "--out", "x.png", "--frame", "1,,2"}, {"--frame: the value is empty"});
    expect_error(64, {"render", "many", "--out", "x.png", "--level", ","}, {"--level: the value is empty"});
    expect_error(64, {"robot", "r.urdf", "--package", "panda="}, {"--package", "NAME=FOLDER"});
    expect_error(64, {"clash", "a.obj", "b.obj", "--units", "a*="}, {"--units"});
    expect_error(64, {"accuracy", "study", "many", "--max-errors", "1cm,,2cm"}, {"--max-errors"});
    expect_error(64, {"accuracy", "study", "many", "--depths", "4,"}, {"--depths"});
}

TEST_F(EmptyValues, AreNamedAsUsersMeetThem)
{
    expect_error(64, {"robot", "r.urdf", "--world", ""},
                 {"robot: --world: the value is empty; is a shell variable not set?", "(oncollide robot --help)"});
    expect_error(64, {"check", "a.off", "b.off", "--pose-b="}, {"check: --pose-b: the value is empty"});
    expect_error(64, {"check", "a.off", ""}, {"check: B: the value is empty"});
    expect_error(64, {"clash", "a.off", ""}, {"clash: parts: the value is empty"});
    expect_error(64, {"run", "city", "--threads", ""}, {"run: --threads: the value is empty"});
}

} // namespace
} // namespace oncollide::test
