#pragma once
#include <oncollide/base/error.hpp>

namespace oncollide {

/// A part of a cooked file cannot be had: it is damaged, cut off, changed since it was opened, or not to be read. Of
/// `NoRoomForChunk` that only the budget is in the way.
class ChunkFault : public Error {
public:
    using Error::Error;
};
class NoRoomForChunk final : public ChunkFault {
public:
    using ChunkFault::ChunkFault;
};

} // namespace oncollide
