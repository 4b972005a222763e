#include "server/app/runtime/host_settings.h"

#include "server/config/expand/load_settings.h"
#include "server/config/text/config_error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

/// From the folder above, so that a folder that was put before a name twice would show.
TEST(TlsSettings, NameFilesOnceFromTheFolderOfTheConfig) {
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(ZONED_SOURCE_DIR);
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    // Any existing file will do: nothing is read from it here.
    const bool good = config::load_settings("config/minimal.txtpb",
                                            {"session.tls_certificate_file=\"minimal.txtpb\"",
                                             "session.tls_key_file=\"valley.txtpb\"",
                                             "session.state_folder=\"here\""},
                                            settings,
                                            errors);
    std::filesystem::current_path(before);
    ASSERT_TRUE(good) << config::format_errors("minimal", errors);
    const net::TlsSettings tls = tls_settings(settings);
    EXPECT_EQ(tls.certificate.certificate_file, "config/minimal.txtpb");
    EXPECT_EQ(tls.certificate.key_file, "config/valley.txtpb");
    EXPECT_EQ(tls.certificate.state_dir, "config/here");
}

}  // namespace
}  // namespace zoned::app
