// config_expand: fills the stages' settings from a Config that has passed the checks.
#pragma once

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Types, brains and the settings of the stages; zones, statics and entities are expanded
/// elsewhere.
void expand_stages(const proto::config::Config& config, Settings& settings);

}  // namespace zoned::config
