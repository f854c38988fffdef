#include "release.hpp"

#include <string>
#include <utility>

#include <pthread.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>

namespace oncollide::python {

namespace {

std::atomic<int> coming_back = 0; ///< threads that wait for the interpreter's lock, or have just acquired it
std::atomic<bool> interpreter_is_ending = false;
std::atomic<pthread_t> ending_thread{};
std::atomic<unsigned long> main_thread = 0; ///< Python's main thread, the only one that handles signals

} // namespace

bool Interrupts::requested()
{
    if (cuts_.load(std::memory_order_relaxed) % 2 == 1) return true;
    if (std::this_thread::get_id() != caller_.load(std::memory_order_relaxed)) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_look_ < std::chrono::milliseconds(20)) return false;
    last_look_ = now;
    PyEval_RestoreThread(*state_);
    handling_ = true;
    const bool raised = PyErr_CheckSignals() != 0;
    handling_ = false;
    if (raised) cuts_.fetch_add(1);
    *state_ = PyEval_SaveThread();
    return raised;
}

void Interrupts::rethrow()
{
    if (std::exchange(caught_, false)) throw pybind11::error_already_set();
}

Released::Released(Interrupts* interrupts)
    : state_(PyEval_SaveThread()), interrupts_(PyThread_get_thread_ident() == main_thread ? interrupts : nullptr)
{
    if (!interrupts_) return;
    interrupts_->caller_ = std::this_thread::get_id();
    interrupts_->state_ = &state_;
    interrupts_->last_look_ = std::chrono::steady_clock::now();
}

Released::~Released()
{
    if (interrupts_) {
        interrupts_->caught_ = interrupts_->cuts_ % 2 == 1;
        if (interrupts_->caught_) interrupts_->cuts_.fetch_add(1);
        interrupts_->caller_ = std::thread::id();
    }
    coming_back.fetch_add(1);
    if (interpreter_is_ending.load() && !pthread_equal(ending_thread.load(), pthread_self())) {
        coming_back.fetch_sub(1);
        for (;;) ::pause();
    }
    PyEval_RestoreThread(state_);
    coming_back.fetch_sub(1);
}

void interpreter_begins()
{
    main_thread = pybind11::module_::import("threading").attr("main_thread")().attr("ident").cast<unsigned long>();
}

/// A thread either sees that the shutdown has begun, or is counted here, and then may finish.
void interpreter_ends()
{
    ending_thread.store(pthread_self());
    interpreter_is_ending.store(true);
    PyThreadState* const state = PyEval_SaveThread();
    while (coming_back.load() > 0) std::this_thread::yield();
    PyEval_RestoreThread(state);
}

namespace {

// The child of fork() has only the calling thread, which becomes its main thread; no other thread is coming back.
[[maybe_unused]] const int at_fork = pthread_atfork(nullptr, nullptr, [] {
    coming_back = 0;
    main_thread = PyThread_get_thread_ident();
});

[[noreturn]] void refuse(const char* call)
{
    throw Error(ErrorKind::usage,
                std::string(call) +
                    ": another thread is in a call of this object, or was when this process was forked; "
                    "let one thread at a time change it, or make one for each thread and process");
}

} // namespace

Users::Alone::Alone(Users& users, const char* call) : users_(users)
{
    int nobody = 0;
    if (!users_.inside_.compare_exchange_strong(nobody, -1, std::memory_order_acquire)) refuse(call);
}

Users::Beside::Beside(Users& users, const char* call) : users_(users)
{
    int inside = users_.inside_.load(std::memory_order_relaxed);
    do {
        if (inside < 0) refuse(call);
    } while (!users_.inside_.compare_exchange_weak(inside, inside + 1, std::memory_order_acquire));
}

} // namespace oncollide::python
