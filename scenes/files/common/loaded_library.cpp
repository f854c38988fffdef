#include <oncollide/scenes/files/common/loaded_library.hpp>

#include <dlfcn.h>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

LoadedLibrary::LoadedLibrary(const char* file, const char* purpose, const char* package)
    : file_(file), purpose_(purpose), package_(package), handle_(::dlopen(file, RTLD_NOW | RTLD_LOCAL))
{
}

void* LoadedLibrary::find(const char* name) const
{
    void* const found = handle_ ? ::dlsym(handle_, name) : nullptr;
    if (!found)
        throw Error(ErrorKind::usage, fmt::format("cannot load {}, which {}: {}; install Debian's {}", file_, purpose_,
                                                  ::dlerror(), package_));
    return found;
}

} // namespace oncollide
