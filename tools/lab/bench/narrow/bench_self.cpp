// oncollide-lab bench self: the triangles of a mesh that meet each other, compared with CGAL.
#include "bench/common/benchmark.hpp"
#include "bench/narrow/folded_cloth.hpp"
#include "peers/peers.hpp"

#include <algorithm>
#include <filesystem>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct SelfOptions : SharedOptions {
    std::vector<std::string> files; ///< empty: generated meshes
    int triangles = 100'000;
};

using TrianglePairs = std::vector<TrianglePair>;

class OurSelfPeer final : public SelfPeer {
public:
    explicit OurSelfPeer(const Mesh& mesh) : mesh_(mesh) {}
    void pairs(TrianglePairs& found) override
    {
        found.clear();
        for (const auto& [a, b] : self_contacts(mesh_)) found.push_back({a, b});
    }

private:
    const Mesh& mesh_;
};

std::vector<std::pair<std::string, Mesh>> meshes_of(const SelfOptions& options)
{
    std::vector<std::pair<std::string, Mesh>> meshes;
    for (const std::string& file : options.files)
        meshes.emplace_back(std::filesystem::path(file).stem().string(), load_mesh(file));
    if (!meshes.empty()) return meshes;
    const int count = options.triangles;
    meshes.emplace_back("folded cloth", make_folded_cloth(count, 0.2));
    meshes.emplace_back("cloth that crosses itself", make_folded_cloth(count, 0.8));
    meshes.emplace_back("knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, count));
    meshes.emplace_back("knot that crosses itself", make_torus_knot_mesh(3, 7, 1, 0.4, 0.35, count));
    return meshes;
}

/// True where the rules differ. CGAL does not compare triangles without area, and neighbours are triangles that share
/// an index.
bool rules_differ(const Mesh& mesh, TrianglePair pair)
{
    int equal = 0;
    for (const std::uint32_t triangle : {pair.a, pair.b}) {
        const auto& [a, b, c] = mesh.triangles[triangle];
        if (collinear(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c])) return true;
    }
    for (const std::uint32_t v : mesh.triangles[pair.a])
        for (const std::uint32_t w : mesh.triangles[pair.b]) equal += v != w && mesh.vertices[v] == mesh.vertices[w];
    return equal > 0;
}

struct SelfResult {
    double ms = 0;
    TrianglePairs pairs; ///< sorted
};

/// Returns the exit code: 70 if a pair differs without a reason in the rules.
int bench_self(const SelfOptions& options)
{
    SelfContenders contenders = all_contenders().self;
    contenders.all.insert(contenders.all.begin(), {.name = "oncollide",
                                                   .what = "self_contacts() of a mesh",
                                                   .group = Group::oncollide,
                                                   .make = maker<OurSelfPeer>()});
    contenders.keep(options.only);
    say("{}", describe_program("cpu"));
    print_missing(contenders.missing);
    say("one thread, processor time; least of {} runs. The linked mesh that CGAL needs is made before.\n",
        options.repeats);
    ResultTable table(options.csv, {26, 10});
    bool wrong = false;
    for (const auto& [name, mesh] : meshes_of(options)) {
        std::vector<std::unique_ptr<SelfPeer>> peers;
        std::vector<SelfResult> results(contenders.all.size());
        for (const SelfContender& contender : contenders.all) {
            try {
                peers.push_back(contender.make(mesh));
            } catch (const Error& error) {
                say("left out   {}, {}: {}\n", name, contender.name, error.what());
                peers.push_back(nullptr);
            }
        }
        for (int run = 0; run < options.repeats; ++run)
            for (std::size_t c = 0; c < peers.size(); ++c) {
                if (!peers[c]) continue;
                const double from = processor_ms();
                peers[c]->pairs(results[c].pairs);
                const double ms = processor_ms() - from;
                results[c].ms = run ? std::min(results[c].ms, ms) : ms;
            }
        for (SelfResult& result : results) std::ranges::sort(result.pairs);
        for (std::size_t c = 0; c < peers.size(); ++c) {
            if (!peers[c]) continue;
            TrianglePairs different;
            std::ranges::set_symmetric_difference(results[c].pairs, results[0].pairs, std::back_inserter(different));
            const auto by_rule =
                std::ranges::count_if(different, [&](TrianglePair pair) { return rules_differ(mesh, pair); });
            const auto unexplained = std::ssize(different) - by_rule;
            wrong |= unexplained > 0;
            table.row(figures("mesh", name, "contender", contenders.all[c].name, "triangles", mesh.triangles.size(),
                              "ms", results[c].ms, "ns_per_triangle",
                              1e6 * results[c].ms / double(mesh.triangles.size()), "ratio",
                              results[c].ms / results[0].ms, "pairs", results[c].pairs.size(), "by_rule", by_rule,
                              "unexplained", unexplained));
        }
    }
    table.commit();
    return code_of(wrong);
}

} // namespace

void add_self(Arguments bench)
{
    Benchmark<SelfOptions> b(bench, "self", "Triangles of one mesh that meet each other", bench_self);
    b.input("files FILE...", b->files, "mesh files (default: generated cloths and knots)").expected(0, 1000);
    b.whole("--triangles N", b->triangles, "approximate triangles of the generated meshes", {1000, 100'000'000});
    b.repeats(), b.only(), b.csv("mesh and contender");
    b.footer(
        "'ratio': to the time of the first contender. Pairs that differ from its pairs: 'by rule', as CGAL compares\n"
        "no triangle without area, and takes vertices at one position for different ones; or 'unexplained'.\n"
        "Exit code 70: a difference is unexplained.");
}

} // namespace oncollide::tools
