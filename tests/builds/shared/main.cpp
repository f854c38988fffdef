// A user of the shared library: exceptions, classes that derive from the library's, and its threads' work cross its
// border.
#include <cstdio>
#include <stdexcept>
#include <typeinfo>

#include <oncollide/base/executor.hpp>
#include <oncollide/oncollide.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace {

using namespace oncollide;

struct Stopped : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct StopAtThird : BodySink {
    bool wants(std::uint32_t) const override { return true; }
    void take(std::uint32_t body, BodyInit) override
    {
        if (body == 2) throw Stopped("the third body");
    }
};

struct OneAfterTheOther : Executor {
    int tasks_run = 0;
    int threads() const override { return 2; }
    void run(int tasks, const std::function<void(int)>& work) override
    {
        for (int task = 0; task < tasks; ++task, ++tasks_run) work(task);
    }
};

bool ours_is_the_librarys_error()
{
    try {
        make_mesh("nothing", {}, {});
    } catch (const std::exception& e) { // the test needs its dynamic type
        const auto* const error = dynamic_cast<const Error*>(&e);
        return typeid(e) == typeid(Error) && error && error->kind() == ErrorKind::bad_data;
    }
    return false;
}

bool an_exception_of_ours_passes_through()
{
    StopAtThird sink;
    try {
        make_scene("paper", sink);
    } catch (const Stopped&) {
        return true;
    }
    return false;
}

bool our_threads_do_the_work()
{
    OneAfterTheOther executor;
    World world({.threads = 2, .executor = &executor});
    const ModelId ball = world.models().add(Sphere{.radius = 0.6});
    for (int i = 0; i < 1000; ++i) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation().x() = i;
        world.bodies().add({.model = ball, .pose = pose});
    }
    return world.step().pairs.size() == 999 && executor.tasks_run > 0;
}

} // namespace

int main()
{
    const bool fine[] = {ours_is_the_librarys_error(), an_exception_of_ours_passes_through(),
                         our_threads_do_the_work()};
    std::printf("errors %d, exceptions %d, threads %d\n", fine[0], fine[1], fine[2]);
    return fine[0] && fine[1] && fine[2] ? 0 : 1;
}
