// three-mesh-bvh, which is in JavaScript: node runs three_mesh_bvh/league.mjs and talks by pipes. It takes part if node
// is there and `npm ci` has installed the packages beside the script.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "common.hpp"

namespace {

namespace fs = std::filesystem;

fs::path folder()
{
    const char* const other = std::getenv("ONCOLLIDE_LEAGUE_THREE_MESH_BVH");
    return other ? other : LEAGUE_THREE_MESH_BVH_FOLDER;
}

bool has_node()
{
    std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
    for (std::size_t begin = 0; begin < path.size();) {
        const std::size_t end = std::min(path.find(':', begin), path.size());
        if (::access((path.substr(begin, end - begin) + "/node").c_str(), X_OK) == 0) return true;
        begin = end + 1;
    }
    return false;
}

bool is_installed()
{
    std::error_code error;
    return has_node() && fs::exists(folder() / "node_modules/three-mesh-bvh/package.json", error) &&
           fs::exists(folder() / "node_modules/three/package.json", error);
}

/// The numbers of a reply, see league.mjs.
struct Reply {
    double works, seconds, meet, distance, time, has_points, points[6];
};

/// The script in a process of its own, which ends with this one: its input closes, or the kernel kills it.
class Node {
public:
    Node()
    {
        int in[2], out[2];
        if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
        const std::string script = (folder() / "league.mjs").string();
        const pid_t child = ::fork();
        if (child < 0) throw std::runtime_error("no process");
        if (child == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            const int nowhere = ::open("/dev/null", O_WRONLY);
            // The pipes may have the numbers that they get here, and dup2() does not clear O_CLOEXEC then.
            const int input = ::fcntl(in[0], F_DUPFD, 10), output = ::fcntl(out[1], F_DUPFD, 10);
            ::dup2(input, 0), ::dup2(nowhere, 1), ::dup2(nowhere, 2), ::dup2(output, 3);
            ::close_range(4, ~0u, 0);
            ::execlp("node", "node", script.c_str(), nullptr);
            ::_exit(127);
        }
        ::close(in[0]), ::close(out[1]);
        input_ = in[1], output_ = out[0];
    }

    /// Ends this process if the script has ended: it crashed.
    Reply send(const std::vector<double>& numbers) const
    {
        const double count = double(numbers.size());
        move<const char>(::write, input_, &count, sizeof count);
        move<const char>(::write, input_, numbers.data(), sizeof(double) * numbers.size());
        Reply reply;
        move<char>(::read, output_, &reply, sizeof reply);
        return reply;
    }

private:
    template <class Byte, class Call, class Data>
    static void move(Call call, int file, Data* data, std::size_t size)
    {
        for (auto* at = reinterpret_cast<Byte*>(data); size > 0;) {
            const ssize_t moved = call(file, at, size);
            if (moved <= 0) std::abort();
            at += moved, size -= std::size_t(moved);
        }
    }

    int input_ = -1, output_ = -1;
};

const Node& node()
{
    static const Node started;
    return started;
}

/// The script's numbers of its queries.
enum Kind { meet, distance, ray, sphere, box };

class Query final : public league::Query {
public:
    explicit Query(const league_case& asked)
    {
        const bool swap = !league::has_triangles(asked.a.kind);
        const league_body &a = swap ? asked.b : asked.a, &b = swap ? asked.a : asked.b;
        const Kind kind = asked.question == LEAGUE_RAY        ? ray
                          : asked.question == LEAGUE_DISTANCE ? distance
                          : league::has_triangles(b.kind)     ? meet
                          : b.kind == LEAGUE_SPHERE           ? sphere
                                                              : box;
        add({double(kind)});
        add_mesh(a);
        if (kind == meet || kind == distance) add_mesh(b);
        if (kind == sphere || kind == box) add(b.size), add_pose(b);
        if (kind == ray) add(asked.from), add(asked.motion);
        if (node().send(numbers_).works == 0) throw std::runtime_error("no tree");
        numbers_.clear();
    }

    int answer(const league_case&, league_answer& answer) override
    {
        const Reply reply = node().send({});
        answer.meet = reply.meet != 0;
        answer.distance = reply.distance, answer.time = reply.time, answer.seconds = reply.seconds;
        answer.has_points = !answer.meet && reply.has_points != 0;
        std::copy_n(reply.points, 3, answer.point_a), std::copy_n(reply.points + 3, 3, answer.point_b);
        return reply.works != 0 ? LEAGUE_ANSWERED : LEAGUE_FAILED;
    }

private:
    void add(std::initializer_list<double> numbers) { numbers_.insert(numbers_.end(), numbers); }
    void add(const double (&vector)[3]) { numbers_.insert(numbers_.end(), vector, vector + 3); }
    void add_pose(const league_body& body)
    {
        numbers_.insert(numbers_.end(), body.rotation, body.rotation + 9);
        add(body.position);
    }
    void add_mesh(const league_body& body)
    {
        add_pose(body);
        add({double(body.vertex_count), double(body.triangle_count)});
        numbers_.insert(numbers_.end(), body.vertices, body.vertices + 3 * body.vertex_count);
        numbers_.insert(numbers_.end(), body.triangles, body.triangles + 3 * body.triangle_count);
    }

    std::vector<double> numbers_;
};

int supports(int question, int kind_a, int kind_b)
{
    const bool mesh_a = league::has_triangles(kind_a), mesh_b = league::has_triangles(kind_b);
    const auto is_shape = [](int kind) { return kind == LEAGUE_SPHERE || kind == LEAGUE_BOX; };
    switch (question) {
    case LEAGUE_MEET:
        return (mesh_a && (mesh_b || is_shape(kind_b))) || (mesh_b && is_shape(kind_a));
    case LEAGUE_DISTANCE:
        return mesh_a && mesh_b;
    default:
        return question == LEAGUE_RAY && mesh_a;
    }
}

/// It knows surfaces alone. The script keeps the last case that was prepared, as the league needs it.
std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    return league::needs_inside(asked) ? nullptr : std::make_unique<Query>(asked);
}

constexpr league_library libraries[] = {league::library_of<prepare>({
    .name = "three-mesh-bvh",
    .settings = "0.9.17 with three 0.187.0; positions are single precision; MeshBVH of both, intersectsGeometry(), "
                "closestPointToGeometry(), raycastFirst() of both sides, intersectsSphere(), intersectsBox(); node's "
                "clock, the least of three calls in a row",
    .source = "three-mesh-bvh, README.md and src/core/MeshBVH.js",
    .supports = supports,
    .bits = 32,
})};

} // namespace

const league_library* league_open(int number)
{
    return is_installed() ? league::library_at(libraries, number) : nullptr;
}
