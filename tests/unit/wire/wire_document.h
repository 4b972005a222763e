// WireDocument: the examples of proto/WIRE.md, for the tests that hold the code to them.
#pragma once

#include "shared/wire/quantize.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace zoned::wire::testing {

using Bytes = std::vector<std::uint8_t>;

/// One ```wire block: its name and its `key = value` lines; `command` may occur several times.
struct Example {
    std::string name;
    int line = 0;
    std::multimap<std::string, std::string> values;

    [[nodiscard]] bool has(const std::string& key) const { return values.contains(key); }

    [[nodiscard]] std::string text(const std::string& key) const {
        const auto it = values.find(key);
        return it == values.end() ? std::string() : it->second;
    }

    /// All numbers of a line; an absent line is no numbers.
    [[nodiscard]] std::vector<double> numbers(const std::string& key) const {
        std::istringstream in(text(key));
        std::vector<double> out;
        for (double d = 0; in >> d;) {
            out.push_back(d);
        }
        return out;
    }

    [[nodiscard]] std::int64_t number(const std::string& key) const {
        const auto all = numbers(key);
        return all.empty() ? 0 : static_cast<std::int64_t>(all[0]);
    }

    [[nodiscard]] Bytes bytes(const std::string& key) const {
        std::istringstream in(text(key));
        Bytes out;
        for (unsigned b = 0; in >> std::hex >> b;) {
            out.push_back(static_cast<std::uint8_t>(b));
        }
        return out;
    }
};

inline std::vector<std::string> document_lines() {
    std::ifstream in(ZONED_SOURCE_DIR "/proto/WIRE.md");
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) {
        lines.push_back(line);
    }
    return lines;
}

inline std::vector<Example> examples() {
    std::vector<Example> out;
    bool inside = false;
    int number = 0;
    for (const std::string& line : document_lines()) {
        ++number;
        if (line.starts_with("```wire ")) {
            inside = true;
            out.push_back({line.substr(8), number, {}});
        } else if (line.starts_with("```")) {
            inside = false;
        } else if (inside) {
            const std::size_t equals = line.find(" = ");
            EXPECT_NE(equals, std::string::npos) << "line " << number;
            out.back().values.emplace(line.substr(0, equals), line.substr(equals + 3));
        }
    }
    return out;
}

inline std::vector<Example> examples_named(const std::string& name) {
    std::vector<Example> out = examples();
    std::erase_if(out, [&](const Example& e) { return e.name != name; });
    return out;
}

inline std::array<std::int32_t, 3> triple(const Example& e, const std::string& key) {
    const auto all = e.numbers(key);
    std::array<std::int32_t, 3> out{};
    for (std::size_t i = 0; i < all.size() && i < 3; ++i) {
        out[i] = static_cast<std::int32_t>(all[i]);
    }
    return out;
}

inline QuantizedState state_in(const Example& e, const std::string& prefix) {
    QuantizedState s;
    const std::int64_t motion = e.number(prefix + "motion");
    s.at_rest = motion == 0;
    s.order = static_cast<motion::PredictorOrder>(std::max<std::int64_t>(motion - 1, 0));
    s.position = triple(e, prefix + "position");
    s.velocity = triple(e, prefix + "velocity");
    s.acceleration = triple(e, prefix + "acceleration");
    s.orientation = triple(e, prefix + "orientation");
    s.orientation_largest = static_cast<std::int32_t>(e.number(prefix + "orientation_largest"));
    s.angular_velocity = triple(e, prefix + "angular_velocity");
    s.turn = triple(e, prefix + "turn");
    s.floor = static_cast<std::int32_t>(e.number(prefix + "floor"));
    s.appearance = static_cast<std::uint16_t>(e.number(prefix + "appearance"));
    return s;
}

}  // namespace zoned::wire::testing
