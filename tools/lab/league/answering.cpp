#include "league/answering.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <limits>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/program_output.hpp>

namespace oncollide::tools {
namespace {

constexpr unsigned most_seconds = 5; ///< of one case
constexpr rlim_t most_bytes = rlim_t{2} << 30;
constexpr int most_ends = 10; ///< of processes, in one row of cases

/// A reply in the pipe; its pairs and contacts follow.
struct Record {
    std::uint64_t seed;
    double nanoseconds;
    league_answer answer;
    std::int32_t state;
};

void write_all(int file, const void* data, std::size_t size)
{
    for (const char* at = static_cast<const char*>(data); size > 0;) {
        const ssize_t written = ::write(file, at, size);
        if (written <= 0) std::exit(int(ErrorKind::cannot_write));
        at += written, size -= std::size_t(written);
    }
}

/// True if float holds the bodies' shapes: the smaller one is not below 2^-14 of the coordinates.
bool fits_float(const LeagueCase& asked)
{
    if (asked.question == LEAGUE_PAIRS) return true; // exact in float
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const LeagueBody* body : {&asked.a, asked.has_b() ? &asked.b : &asked.a}) {
        if (body->size() > 0) least = std::min(least, body->size());
        most = std::max(most, body->pose.translation().cwiseAbs().maxCoeff());
        if (const auto* mesh = std::get_if<Mesh>(&body->geometry))
            most = std::max({most, mesh->bounds.min.cwiseAbs().maxCoeff(), mesh->bounds.max.cwiseAbs().maxCoeff()});
    }
    return least >= 0x1p-14 * most;
}

/// Queries, and writes the reply before the library's memory goes.
void ask(const league_library& library, const league_case& asked, std::uint64_t seed, int replies)
{
    Record record{.seed = seed, .nanoseconds = 0, .answer = {}, .state = LEAGUE_UNSUPPORTED};
    const bool pairs = asked.question == LEAGUE_PAIRS;
    const auto [a, b] = kinds_of(asked);
    if (!library.supports(asked.question, a, b)) return write_all(replies, &record, sizeof record);
    void* const prepared = library.prepare(&asked);
    if (prepared) record.nanoseconds = 1e300;
    for (int call = 0; prepared && call < (pairs ? 1 : 3); ++call) {
        record.answer = {};
        const auto start = std::chrono::steady_clock::now();
        record.state = library.answer(prepared, &asked, &record.answer);
        const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
        record.nanoseconds =
            std::min(record.nanoseconds, record.answer.seconds > 0 ? 1e9 * record.answer.seconds : time.count());
    }
    write_all(replies, &record, sizeof record);
    write_all(replies, record.answer.pairs, 8 * record.answer.pair_count);
    write_all(replies, record.answer.contacts, sizeof(league_contact) * record.answer.contact_count);
    if (prepared) library.release(prepared);
}

} // namespace

std::pair<int, int> kinds_of(const league_case& asked)
{
    if (asked.question == LEAGUE_PAIRS) return {LEAGUE_BOX, LEAGUE_BOX};
    return {asked.a.kind, asked.question < LEAGUE_RAY ? asked.b.kind : asked.a.kind};
}

void answer_in_child(const LeagueFamily& family, const league_library& library, std::uint64_t first,
                     std::uint64_t count)
{
    // Libraries print warnings: their standard output is not the replies'.
    const int replies = ::dup(STDOUT_FILENO), nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    const rlimit limit{most_bytes, most_bytes}, none{0, 0};
    ::setrlimit(RLIMIT_DATA, &limit), ::setrlimit(RLIMIT_CORE, &none);
    for (const int signal : {SIGALRM, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, SIG_DFL);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        LeagueCase made = family.make(seed);
        if (library.bits == 32 && !fits_float(made)) {
            const Record record{.seed = seed, .nanoseconds = 0, .answer = {}, .state = LEAGUE_UNSUPPORTED};
            write_all(replies, &record, sizeof record);
            continue;
        }
        const AskedCase asked(library.bits == 32 ? rounded_to_float(std::move(made)) : std::move(made));
        ::alarm(most_seconds);
        ask(library, asked.view(), seed, replies);
        ::alarm(0);
    }
}

std::vector<LeagueReply> ask_in_child(const LeagueFamily& family, const LeagueEntry& entry, std::uint64_t first,
                                      std::uint64_t count)
{
    std::vector<LeagueReply> replies;
    LeagueReply::State last = LeagueReply::State::crashed;
    for (int ends = 0; replies.size() < count && ends < most_ends; ++ends) {
        const std::uint64_t next = first + replies.size();
        const ProgramOutput output =
            output_of("/proc/self/exe",
                      {"league", "--adapter", entry.adapter, "--library", entry.library->name, "--family", family.name,
                       "--seed", std::to_string(next), "--cases", std::to_string(first + count - next), "--answers"},
                      {.bytes = std::size_t{512} << 20, .time = std::chrono::milliseconds(600'000)});
        std::size_t at = 0;
        while (at + sizeof(Record) <= output.output.size()) {
            Record record;
            std::memcpy(&record, output.output.data() + at, sizeof record), at += sizeof record;
            LeagueReply reply{record.seed, LeagueReply::State(record.state), record.nanoseconds, record.answer, {}, {}};
            const auto take = [&]<class Item>(std::vector<Item>& items, std::size_t count) {
                if (count > (output.output.size() - at) / sizeof(Item)) return false;
                items.resize(count);
                std::memcpy(items.data(), output.output.data() + at, count * sizeof(Item));
                at += count * sizeof(Item);
                return true;
            };
            if (!take(reply.pairs, 2 * reply.answer.pair_count) || !take(reply.contacts, reply.answer.contact_count))
                break;
            replies.push_back(std::move(reply));
        }
        if (replies.size() >= count) break;
        const bool hung = output.end != ProgramOutput::End::killed ? output.end != ProgramOutput::End::exited
                                                                   : output.code == SIGALRM;
        last = hung ? LeagueReply::State::hung : LeagueReply::State::crashed;
        replies.push_back({first + replies.size(), last, 0, {}, {}, {}});
    }
    while (replies.size() < count) replies.push_back({first + replies.size(), last, 0, {}, {}, {}});
    for (LeagueReply& reply : replies)
        reply.answer.pairs = reply.pairs.data(), reply.answer.contacts = reply.contacts.data();
    return replies;
}

} // namespace oncollide::tools
