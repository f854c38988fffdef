// 'oncollide view': writes the page of a run that was stored with --pairs.
#include <limits>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/system.hpp"
#include "view/stored_frames.hpp"
#include "view/view_page.hpp"

namespace oncollide::tools {
namespace {

struct ViewOptions {
    std::string results, scene, out, data;
    std::optional<int> from, to;
    int limit = 40; ///< MB
    int threads = 1;
    bool quiet = false;
};

int view(const ViewOptions& o)
{
    check_range("--threads", o.threads, 0);
    check_view("--out", o.out, o.limit, {}, {o.results, o.scene});
    StoredFrames frames(o.results, o.scene, o.data, o.threads);
    const int first = o.from.value_or(frames.first()), last = o.to.value_or(frames.last());
    for (const auto& [option, frame] : {std::pair("--from-frame", first), std::pair("--to-frame", last)})
        if (frame < frames.first() || frame > frames.last())
            usage(
                fmt::format("{} {}: {} has frames {} to {}", option, frame, o.results, frames.first(), frames.last()));
    if (first > last) usage(fmt::format("--from-frame {} is after --to-frame {}", first, last));
    if (!o.quiet) print_warnings(frames.scene());
    ViewPage page(frames.scene(), frames.pipeline(),
                  {.file = o.out,
                   .most_bytes = std::size_t(o.limit) * 1'000'000,
                   .separate = frames.separate(),
                   .frames = std::size_t(last - first + 1),
                   .threads = o.threads,
                   .results = o.results});
    catch_interrupts();
    int next = first;
    {
        Progress progress("frame", std::size_t(last - first + 1), o.quiet);
        for (; next <= last && !interrupted(); ++next) page.add(frames.play(next)), progress.step();
    }
    page.close();
    if (!o.quiet && next > first) log(LogLevel::note, page.summary());
    if (next > last) return 0;
    log(LogLevel::error,
        fmt::format("interrupted after {} of {} frames; the page shows only these", next - first, last - first + 1));
    return interrupted_code;
}

} // namespace

void add_view(Arguments app)
{
    Arguments sub = app.add_command("view", "Write a 3D HTML page of a run that was stored with --pairs");
    auto o = std::make_shared<ViewOptions>();
    sub.add_option("results RESULTS.h5", o->results, "results file of 'oncollide run --pairs'").required();
    sub.add_option("scene SCENE.json|ASSEMBLY|NAME", o->scene, "scene of the run, if it has moved since");
    sub.add_option("-o,--out PAGE.html", o->out, "page to write; needs three.js (Debian: libjs-three)").required();
    sub.add_option("--from-frame N", o->from, "first frame to show (default: the first of the results)");
    sub.add_option("--to-frame N", o->to, "last frame to show (default: the last of the results)");
    add_view_limit(sub, o->limit);
    sub.add_option("--data DIR", o->data, "data folder of a scene of the catalogue (default: the run's)");
    sub.add_option("--threads N", o->threads,
                   "number of threads; 0: all. Does not change the page's results (default 1)");
    sub.add_flag("--quiet", o->quiet, "print only errors");
    sub.footer(
        "Example:\n"
        "  oncollide run city --exact on --pairs city.h5\n"
        "  oncollide view city.h5 -o city.html\n"
        "The page shows the verdicts, bounds and times of the run; its narrow phase does not run again. The page is\n"
        "described in docs/view.md. 'oncollide run --view' writes it during the run.");
    sub.action([o] { return view(*o); });
}

} // namespace oncollide::tools
