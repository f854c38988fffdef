#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::test {

/// Mutates a JSON text by its structure: one to three values are removed, copied from elsewhere in it, or drawn from a
/// list. Deterministic for a round.
class StructureMutator {
public:
    StructureMutator(nlohmann::json valid, std::vector<nlohmann::json> drawn)
        : valid_(std::move(valid)), drawn_(std::move(drawn))
    {
    }

    nlohmann::json operator()(std::uint64_t round) const
    {
        using nlohmann::json;
        std::uint64_t draws = 0;
        const auto pick = [&](std::size_t n) {
            return static_cast<std::size_t>(u01(14, round, draws++) * static_cast<double>(n));
        };
        json file = valid_;
        for (std::size_t change = 0; change < 1 + pick(3); ++change) {
            std::vector<json*> values;
            collect(file, values);
            json& value = *values[pick(values.size())];
            switch (pick(4)) {
            case 0:
                if (value.is_structured() && !value.empty())
                    value.erase(std::next(value.begin(), static_cast<int>(pick(value.size()))));
                break;
            case 1:
                value = json(*values[pick(values.size())]);
                break;
            default:
                value = drawn_[pick(drawn_.size())];
            }
        }
        return file;
    }

private:
    /// Collects `json` and every value inside it.
    static void collect(nlohmann::json& json, std::vector<nlohmann::json*>& values)
    {
        values.push_back(&json);
        if (json.is_structured())
            for (nlohmann::json& child : json) collect(child, values);
    }

    nlohmann::json valid_;
    std::vector<nlohmann::json> drawn_;
};

} // namespace oncollide::test
