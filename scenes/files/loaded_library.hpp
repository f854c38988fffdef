#pragma once

namespace oncollide {

/// A shared library that is loaded when a file first needs it. Private to scenes.
class LoadedLibrary {
public:
    /// @param file     the library's, with the number of its interface: "libgdal.so.32"
    /// @param purpose  what it does, for messages: "reads such files"
    /// @param package  of Debian, in which it is
    LoadedLibrary(const char* file, const char* purpose, const char* package);

    /// What the library calls `name`. Throws Error{usage} where this machine does not have it.
    void* find(const char* name) const;

private:
    const char *file_, *purpose_, *package_;
    void* handle_;
};

} // namespace oncollide
