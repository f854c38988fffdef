#pragma once
#include <string>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

/// The message of the Error that the call throws.
inline std::string refusal(auto call)
{
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "not refused";
}

inline void says(const std::string& message, const char* words)
{
    EXPECT_NE(message.find(words), std::string::npos) << message;
}

} // namespace oncollide
