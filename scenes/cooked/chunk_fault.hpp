#pragma once
#include <oncollide/base/error.hpp>

namespace oncollide {

/// A part of a cooked file is unavailable: it is damaged, cut off, changed since it was opened, or unreadable.
/// `NoRoomForChunk`: only the memory budget prevents reading it.
class ChunkFault : public Error {
public:
    using Error::Error;
};
class NoRoomForChunk final : public ChunkFault {
public:
    using ChunkFault::ChunkFault;
};

} // namespace oncollide
