#pragma once
#include <cstddef>
#include <memory>
#include <type_traits>

namespace oncollide {

/// Reference to a callable: no allocation, no ownership.
template <class Signature>
class FunctionRef;
template <class R, class... Args>
class FunctionRef<R(Args...)> {
public:
    template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>) FunctionRef(F&& f) // NOLINT: implicit on purpose
        : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
          call_([](void* object, Args... args) -> R {
              return (*static_cast<std::remove_reference_t<F>*>(object))(static_cast<Args>(args)...);
          })
    {
    }
    R operator()(Args... args) const { return call_(object_, static_cast<Args>(args)...); }

private:
    void* object_;
    R (*call_)(void*, Args...);
};

/// Calls work(begin, end, thread) for chunks of at most `grain` items that cover [0, count) once, on up to `threads`
/// OpenMP threads; `thread` is in [0, threads). Which thread gets which chunk is not fixed: results must be joined by
/// item. With one thread or one chunk it is a plain call. `work` must not throw.
void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     FunctionRef<void(std::size_t begin, std::size_t end, int thread)> work);

/// The number of hardware threads that this process may use; >= 1.
int hardware_threads();

} // namespace oncollide
