#pragma once
#include <atomic>
#include <chrono>
#include <thread>

#include <pybind11/pybind11.h>

namespace oncollide::python {

/// Ctrl-C in a long call: if Python's main thread made the call, it regularly checks whether Python has a signal to
/// handle, and the call ends early if the handler raises. Settings::stop calls requested(); one per World.
class Interrupts {
public:
    bool requested();
    /// Call it after the call: throws the exception that a handler raised meanwhile.
    void rethrow();

    /// A call on another thread may have been cut short, too, if cuts() was odd before the call or has changed after
    /// it; then repeat the call.
    unsigned cuts() const { return cuts_.load(std::memory_order_acquire); }
    /// True in a handler that runs in the middle of a call.
    bool in_handler() const
    {
        return handling_.load(std::memory_order_relaxed) && caller_.load() == std::this_thread::get_id();
    }

private:
    friend class Released;
    std::atomic<unsigned> cuts_ = 0; ///< odd: a handler raised in the current call; the exception is then the thread's
    std::atomic<bool> handling_ = false;
    bool caught_ = false;                   ///< in the last call
    std::atomic<std::thread::id> caller_{}; ///< the thread of the current call
    PyThreadState** state_ = nullptr;
    std::chrono::steady_clock::time_point last_look_;
};

/// Releases the interpreter's lock to other threads during its lifetime.
///
/// A thread that returns while the interpreter shuts down must not wait for that lock: CPython would end it by
/// unwinding through frames that must not be unwound, which aborts the process. The thread blocks until the process
/// ends instead.
class Released {
public:
    Released() : Released(nullptr) {}
    explicit Released(Interrupts* interrupts); ///< null: nothing interrupts the call
    ~Released();
    Released(const Released&) = delete;
    Released& operator=(const Released&) = delete;
    bool interruptible() const { return interrupts_; }

private:
    PyThreadState* state_;
    Interrupts* interrupts_;
};

/// Call them when the module is imported, and when the interpreter begins to shut down.
void interpreter_begins();
void interpreter_ends();

/// Users of an object that does not lock itself: any number of const calls, or one other call. Further calls are
/// refused with an exception instead of waiting, because a process that was forked during a call would wait forever.
class Users {
public:
    /// Throws Error{usage} while another call is active.
    class Alone {
    public:
        Alone(Users& users, const char* call);
        ~Alone() { users_.inside_.store(0, std::memory_order_release); }
        Alone(const Alone&) = delete;
        Alone& operator=(const Alone&) = delete;

    private:
        Users& users_;
    };
    /// Throws Error{usage} while a call that is not const is active.
    class Beside {
    public:
        Beside(Users& users, const char* call);
        ~Beside() { users_.inside_.fetch_sub(1, std::memory_order_release); }
        Beside(const Beside&) = delete;
        Beside& operator=(const Beside&) = delete;

    private:
        Users& users_;
    };

private:
    std::atomic<int> inside_ = 0; ///< number of const calls; -1: another call
};

} // namespace oncollide::python
