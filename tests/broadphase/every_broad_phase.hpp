#pragma once
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>

#include "boxes.hpp"

namespace oncollide::broad_phase_test {

struct Algorithm {
    const char* name;
    std::unique_ptr<BroadPhase> (*make)(const BroadPhase::Options&);
    BroadPhase::Options options;
};

inline std::string message_of(auto&& work)
{
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

class EveryBroadPhase : public ::testing::TestWithParam<Algorithm> {
protected:
    std::unique_ptr<BroadPhase> make() const { return GetParam().make(GetParam().options); }
    /// The pairs of a new broad phase for this scene.
    Pairs find_in(const Boxes& scene) const { return find_anew(make(), scene); }
    Pairs truth(const Boxes& scene) const { return scene.truth(margin_); }
    const double margin_ = GetParam().options.margin;
};

} // namespace oncollide::broad_phase_test
