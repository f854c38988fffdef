#pragma once
#include <atomic>
#include <chrono>
#include <thread>

#include <pybind11/pybind11.h>

namespace oncollide::python {

/// Ctrl-C in a long call: Python's main thread, where it made the call, looks now and then whether Python has a signal
/// to handle, and the call ends early where the handler raises. Settings::stop asks it; one for each object, for calls
/// that are alone in it.
class Interrupts {
public:
    bool requested();
    /// After the call: throws what a handler raised meanwhile.
    void rethrow();

private:
    friend class Released;
    std::atomic<bool> raised_ = false; ///< in the call under way; it is the thread's current exception then
    bool caught_ = false;              ///< in the last call
    std::thread::id caller_;           ///< of the call under way
    PyThreadState** state_ = nullptr;
    std::chrono::steady_clock::time_point last_look_;
};

/// Gives the interpreter's lock to other threads for as long as it lives.
///
/// A thread that comes back while the interpreter ends must not wait for that lock any more: CPython would end it by
/// unwinding through frames that may not be unwound, which aborts the process. Such a thread stays where it is until
/// the process is gone.
class Released {
public:
    Released() : Released(nullptr) {}
    explicit Released(Interrupts* interrupts); ///< null: nothing interrupts the call
    ~Released();
    Released(const Released&) = delete;
    Released& operator=(const Released&) = delete;

private:
    PyThreadState* state_;
    Interrupts* interrupts_;
};

/// To be called when the module is imported, and as the interpreter begins to end.
void interpreter_begins();
void interpreter_ends();

/// Who is inside an object that does not lock itself: any number of const calls, or one other. Others are refused, by
/// an exception rather than a wait: a process that was forked in the middle of a call would wait for ever.
class Users {
public:
    /// Throws Error{usage} while another thread is inside.
    class Alone {
    public:
        Alone(Users& users, const char* call);
        ~Alone() { users_.inside_.store(0, std::memory_order_release); }
        Alone(const Alone&) = delete;
        Alone& operator=(const Alone&) = delete;

    private:
        Users& users_;
    };
    /// Throws Error{usage} while another thread is inside with a call that is not const.
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
    std::atomic<int> inside_ = 0; ///< const calls; -1: another call
};

} // namespace oncollide::python
