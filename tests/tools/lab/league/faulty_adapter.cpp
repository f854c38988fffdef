// Libraries with faults that the league must count and survive.
#include <csignal>
#include <cstdlib>
#include <unistd.h>

#include <oncollide/league.h>

namespace {

enum Fault { always_apart, always_meets, crashes, hangs, hungry, fails, talks };

int supports(int question, int, int)
{
    return question == LEAGUE_MEET;
}

int asked_before = 0;

void* prepare(const league_case*)
{
    return &asked_before;
}

template <Fault fault>
int answer(void*, const league_case*, league_answer* answer)
{
    const int number = asked_before++ / 3; // each case is queried three times
    answer->meet = fault == always_meets;
    if (fault == crashes && number % 4 == 3) std::raise(SIGSEGV);
    if (fault == hangs && number == 2)
        for (;;) ::pause();
    if (fault == hungry)
        for (char* more = nullptr;; more[0] = 1)
            if (more = static_cast<char*>(std::malloc(64 << 20)); !more) std::abort();
    if (fault == talks && ::write(STDOUT_FILENO, "a warning of the library\n", 25) != 25) return LEAGUE_FAILED;
    return fault == fails ? LEAGUE_FAILED : LEAGUE_ANSWERED;
}

void release(void*) {}

template <Fault fault>
constexpr league_library made(const char* name)
{
    return {LEAGUE_VERSION, 64, name, "a test", "none", 0, 0, supports, prepare, answer<fault>, release};
}

const league_library libraries[] = {made<always_apart>("apart"), made<always_meets>("meets"), made<crashes>("crashes"),
                                    made<hangs>("hangs"),        made<hungry>("hungry"),      made<fails>("fails"),
                                    made<talks>("talks")};

} // namespace

const league_library* league_open(int number)
{
    if (std::getenv("ONCOLLIDE_FAULTY_OPEN")) std::raise(SIGSEGV);
    return number >= 0 && number < 7 ? &libraries[number] : nullptr;
}
