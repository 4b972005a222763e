#include "server/config/expand/script_config.h"

#include "server/config/text/read_text.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/text_format.h>

#include <filesystem>

namespace zoned::config {

namespace {

constexpr std::size_t kMaxSourceBytes = 1U << 20U;
constexpr std::size_t kMegabyte = 1U << 20U;

/// False after a mistake.
bool read_source(proto::config::Script& script, Diagnostics& diagnostics) {
    if (script.has_text()) {
        return true;
    }
    if (script.file().empty()) {
        diagnostics.add("script", "a script needs a file");
        return false;
    }
    std::string source;
    const std::string wrong = read_text(script.file(), source);
    if (!wrong.empty()) {
        diagnostics.add("script.file", wrong);
        return false;
    }
    if (source.size() > kMaxSourceBytes) {
        diagnostics.add("script.file", script.file() + " is longer than 1 MiB");
        return false;
    }
    script.set_text(source);
    return true;
}

scripting::ScriptSettings script_settings_of(const proto::config::Script& script) {
    scripting::ScriptSettings out;
    out.name = script.has_file() ? std::filesystem::path(script.file()).filename().string()
                                 : std::string("script");
    out.source = script.text();
    out.avatar = script.avatar();
    out.limits = {script.instructions_per_call(),
                  script.instructions_per_tick(),
                  script.memory_mb() * kMegabyte,
                  script.state_mb() * kMegabyte};
    out.errors_allowed = script.errors_allowed();
    out.on_errors = static_cast<scripting::ErrorPolicy>(script.on_errors());
    return out;
}

}  // namespace

std::optional<scripting::ScriptSettings> load_script(proto::config::Config& config,
                                                     Diagnostics& diagnostics) {
    if (!config.has_script() || !read_source(*config.mutable_script(), diagnostics)) {
        return std::nullopt;
    }
    return script_settings_of(config.script());
}

std::optional<scripting::ScriptSettings> script_of(const std::string& config_text) {
    proto::config::Config config;
    if (!google::protobuf::TextFormat::ParseFromString(config_text, &config) ||
        !config.has_script()) {
        return std::nullopt;
    }
    return script_settings_of(config.script());
}

}  // namespace zoned::config
