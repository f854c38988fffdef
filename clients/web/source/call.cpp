#include "call.hpp"

#include <array>
#include <new>

namespace oncollide::web {

namespace {

std::string message;
std::vector<std::uint64_t> input; // 8-byte units: aligned for doubles
std::array<Results, 5> lists;

} // namespace

int answer(void (*work)(void*), void* context)
{
    try {
        work(context);
        return 0;
    } catch (const Error& error) {
        message = error.what();
        return static_cast<int>(error.kind());
    } catch (const std::bad_alloc&) {
        message = "out of memory: WebAssembly has at most 4 GiB";
    } catch (const std::exception& error) {
        message = error.what();
    }
    return static_cast<int>(ErrorKind::internal);
}

Results& results(std::size_t list)
{
    return lists[list];
}

Eigen::Isometry3d pose_at(const double* poses, std::size_t index)
{
    Eigen::Isometry3d pose;
    pose.matrix() = Eigen::Map<const Eigen::Matrix4d>(poses + 16 * index);
    return pose;
}

std::vector<Eigen::Isometry3d> poses_at(const double* poses, std::size_t count)
{
    std::vector<Eigen::Isometry3d> made(count);
    for (std::size_t i = 0; i < count; ++i) made[i] = pose_at(poses, i);
    return made;
}

} // namespace oncollide::web

using namespace oncollide::web;

ONCOLLIDE_WEB const char* oc_message()
{
    return message.c_str();
}
/// The input buffer, with room for `bytes`; null: there is not enough memory.
ONCOLLIDE_WEB void* oc_input(std::size_t bytes)
{
    try {
        if (input.size() * 8 < bytes) {
            input.clear(); // not copied
            input.resize(bytes / 8 + 1);
        }
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
    return input.data();
}
/// Frees the buffers, which a large call has made large.
ONCOLLIDE_WEB void oc_shrink()
{
    std::vector<std::uint64_t>().swap(input);
    lists = {};
}
ONCOLLIDE_WEB const double* oc_results(int list)
{
    return results(static_cast<std::size_t>(list)).data();
}
ONCOLLIDE_WEB std::size_t oc_rows(int list)
{
    return results(static_cast<std::size_t>(list)).rows();
}
