// Config helpers: a small valid config as text, and functions to break it and check mistakes.
#pragma once

#include "server/config/expand/load_settings.h"
#include "proto/config/config.pb.h"
#include "proto/range.pb.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::config::test {

/// Two zones side by side, a player, a crate and a guard; each statement on a line of its own, so
/// that tests can name lines. A literal, since other files' constants are made from it, perhaps
/// before any std::string is there.
inline constexpr char kValidLiteral[] = R"(world {
  name: "test"
  min_x_m: -100
  min_z_m: -50
  max_x_m: 100
  max_z_m: 50
}
zones {
  zone { name: "west" min_x_m: -100 min_z_m: -50 max_x_m: 0 max_z_m: 50 }
  zone { name: "east" min_x_m: 0 min_z_m: -50 max_x_m: 100 max_z_m: 50 }
  ghost_margin_m: 60
}
type {
  name: "player"
  kind: CHARACTER
  capsule { radius_m: 0.4 length_m: 1 }
  aura_m { normal: 50 }
  nimbus_m { normal: 50 }
}
type {
  name: "crate"
  box { x_m: 1 y_m: 1 z_m: 1 }
  aura_m { normal: 50 }
}
type {
  name: "guard"
  kind: CHARACTER
  capsule { radius_m: 0.4 length_m: 1 }
  brain: "guard"
}
brain {
  name: "guard"
  state { name: "rest" action: IDLE transition { to: "chase" sensor: PLAYER_DISTANCE compare: BELOW threshold: 20 } }
  state { name: "chase" action: CHASE }
}
session {
  dev_mode_loopback: true
}
spawn { x_m: 1 z_m: 2 }
lod { radius_m: 30 position_bound_m: 0.05 }
lod { position_bound_m: 0.5 }
)";
inline const std::string kValid = kValidLiteral;

struct Outcome {
    bool ok = false;
    Settings settings;
    std::vector<ConfigError> errors;
};

inline Outcome parse(const std::string& text, const std::vector<std::string>& sets = {}) {
    Outcome out;
    out.ok = parse_settings(text, sets, out.settings, out.errors);
    return out;
}

/// kValid with the first `from` replaced by `to`; `from` must be there.
inline std::string with(const std::string& from,
                        const std::string& to,
                        std::string text = kValidLiteral) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << "the test's text has no '" << from << "'";
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Line and column (from 1) of `needle` in `text`.
inline std::pair<int, int> place_of(const std::string& text, const std::string& needle) {
    const std::size_t at = text.find(needle);
    EXPECT_NE(at, std::string::npos);
    int line = 1;
    int column = 1;
    for (std::size_t i = 0; i < at && i < text.size(); ++i) {
        line += text[i] == '\n' ? 1 : 0;
        column = text[i] == '\n' ? 1 : column + 1;
    }
    return {line, column};
}

/// Exactly one mistake is reported, at the place of `needle`, and its text holds `words`.
inline void expect_single(const std::string& text,
                          const std::string& needle,
                          const std::string& words) {
    SCOPED_TRACE(words);
    const Outcome out = parse(text);
    EXPECT_FALSE(out.ok);
    ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
    const auto [line, column] = place_of(text, needle);
    EXPECT_EQ(out.errors[0].line, line) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].column, column) << format_errors("test", out.errors);
    EXPECT_NE(out.errors[0].text.find(words), std::string::npos) << out.errors[0].text;
}

}  // namespace zoned::config::test
