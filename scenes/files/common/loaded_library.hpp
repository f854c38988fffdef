#pragma once

namespace oncollide {

/// A shared library that is loaded on first use. Private to scenes.
class LoadedLibrary {
public:
    /// @param file     file name with the interface number: "libgdal.so.32"
    /// @param purpose  its use, for messages: "reads such files"
    /// @param package  the Debian package that contains it
    LoadedLibrary(const char* file, const char* purpose, const char* package);

    /// The symbol `name` of the library. Throws Error{usage} if this machine does not have the library.
    void* find(const char* name) const;

private:
    const char *file_, *purpose_, *package_;
    void* handle_;
};

} // namespace oncollide
