// A case as a program of its own.
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "league/judge/league_case.hpp"

namespace oncollide::tools {
namespace {

/// Numbers to the last bit.
template <class Number>
std::string braced(std::span<const Number> numbers)
{
    std::string text;
    for (const Number number : numbers) {
        text += text.empty() ? "" : ", ";
        if constexpr (std::is_floating_point_v<Number>)
            text += fmt::format("{:.17g}", number);
        else
            text += fmt::format("{}", number);
    }
    return "{" + text + "}";
}

/// The body, and the arrays that it points to, whose names begin with `name`.
std::string body_text(const std::string& name, const league_body& body)
{
    std::string text;
    if (body.vertex_count)
        text += fmt::format("const double {}_vertices[] = {};\n", name,
                            braced(std::span(body.vertices, 3 * body.vertex_count)));
    if (body.triangle_count)
        text += fmt::format("const std::uint32_t {}_triangles[] = {};\n", name,
                            braced(std::span(body.triangles, 3 * body.triangle_count)));
    return text + fmt::format("const league_body {0}{{{1}, {2}, {3}, {4}, {5}, {6}, {7}, {8}, {9}}}; // {10}\n", name,
                              body.kind, body.solid, braced(std::span<const double>(body.size)), body.vertex_count,
                              body.vertex_count ? name + "_vertices" : "nullptr", body.triangle_count,
                              body.triangle_count ? name + "_triangles" : "nullptr",
                              braced(std::span<const double>(body.rotation)),
                              braced(std::span<const double>(body.position)), name_of(league_kind(body.kind)));
}

} // namespace

std::string program_of(const league_case& asked, const std::string& library)
{
    const bool pairs = asked.question == LEAGUE_PAIRS, two = asked.question < LEAGUE_RAY;
    std::string text =
        "// g++ -std=c++20 -g -I FOLDER_ABOVE_oncollide/league.h THIS_FILE.cpp -ldl && ./a.out ADAPTER.so\n#include "
        "<oncollide/league.h>\n\n"
        "#include <cstdint>\n#include <cstdio>\n#include <cstring>\n#include <dlfcn.h>\n\n";
    if (!pairs) text += body_text("a", asked.a);
    if (two) text += body_text("b", asked.b);
    if (pairs) {
        std::string all;
        for (std::size_t k = 0; k < asked.body_count; ++k) {
            text += body_text(fmt::format("body_{}", k), asked.bodies[k]);
            all += fmt::format("{}body_{}", k ? ", " : "", k);
        }
        text += fmt::format("const league_body bodies[] = {{{}}};\n", all);
    }
    text += fmt::format("const league_case asked{{{}, {}, {}, {}, {}, {}, {}, {}}}; // {}\n", asked.question,
                        pairs ? "{}" : "a", two ? "b" : "{}", braced(std::span<const double>(asked.from)),
                        braced(std::span<const double>(asked.motion)), braced(std::span<const double>(asked.turn)),
                        asked.body_count, pairs ? "bodies" : "nullptr", name_of(league_question(asked.question)));
    return text + fmt::format(R"(
int main(int, char** words)
{{
    void* const file = dlopen(words[1], RTLD_NOW);
    const auto open = file ? reinterpret_cast<const league_library* (*)(int)>(dlsym(file, "league_open")) : nullptr;
    for (int number = 0; open && open(number); ++number) {{
        const league_library& library = *open(number);
        if (std::strcmp(library.name, "{0}") != 0) continue;
        const int a = {1}, b = {2};
        void* const prepared = library.supports(asked.question, a, b) ? library.prepare(&asked) : nullptr;
        league_answer answer{{}};
        if (!prepared || library.answer(prepared, &asked, &answer) != LEAGUE_ANSWERED) return 1;
        printf("meet %d, distance %.17g, depth %.17g, time %.17g, normal %.17g %.17g %.17g, %zu pairs\n", answer.meet,
               answer.distance, answer.depth, answer.time, answer.normal[0], answer.normal[1], answer.normal[2], answer.pair_count);
        for (std::size_t k = 0; k < answer.contact_count; ++k) {{
            const league_contact& c = answer.contacts[k];
            printf("contact at %.17g %.17g %.17g, normal %.17g %.17g %.17g, depth %.17g\n", c.position[0], c.position[1],
                   c.position[2], c.normal[0], c.normal[1], c.normal[2], c.depth);
        }}
        library.release(prepared);
        return 0;
    }}
    puts(dlerror());
    return 2;
}}
)",
                              library, pairs ? std::to_string(LEAGUE_BOX) : "asked.a.kind",
                              pairs ? std::to_string(LEAGUE_BOX)
                              : two ? "asked.b.kind"
                                    : "asked.a.kind");
}

} // namespace oncollide::tools
