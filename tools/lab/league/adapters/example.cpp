// A toy library for docs/league.md: it knows spheres alone.
#include <oncollide/league.h>

#include <cmath>

namespace {

double distance_of(const league_case* asked)
{
    const league_body &a = asked->a, &b = asked->b;
    const double apart =
        std::hypot(a.position[0] - b.position[0], a.position[1] - b.position[1], a.position[2] - b.position[2]);
    return apart - a.size[0] - b.size[0];
}

int supports(int question, int kind_a, int kind_b)
{
    return (question == LEAGUE_MEET || question == LEAGUE_DISTANCE) && kind_a == LEAGUE_SPHERE &&
           kind_b == LEAGUE_SPHERE;
}

/// A library that keeps trees or models builds them here.
void* prepare(const league_case*)
{
    static int nothing;
    return &nothing;
}

int answer(void*, const league_case* asked, league_answer* answer)
{
    const double distance = distance_of(asked);
    answer->meet = distance <= 0;
    answer->distance = distance > 0 ? distance : 0;
    return LEAGUE_ANSWERED;
}

void release(void*) {}

const league_library library{LEAGUE_VERSION, 64,     "example", "1.0; spheres alone", "docs/league.md", 0, 0, supports,
                             prepare,        answer, release};

} // namespace

const league_library* league_open(int number)
{
    return number == 0 ? &library : nullptr;
}
