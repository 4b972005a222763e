// ConfigSetting: a setting of the config as a page writes it, and whether a world uses it.
#pragma once

#include "proto/config/config.pb.h"

#include <string>
#include <string_view>
#include <vector>

namespace zoned::lint {

/// Written as `type.soft.cloth` or `physics.method=JACOBI`: names of fields from the root of the
/// config, and the value of the last one.
struct ConfigSetting {
    std::vector<const google::protobuf::FieldDescriptor*> path;
    std::string value;  ///< empty: any
};

/// Returns nothing, or why the schema has no such setting.
[[nodiscard]] std::string read_setting(std::string_view text, ConfigSetting& setting);

enum class SettingUse {
    kNone,
    kDefault,  ///< the world leaves the field out, and its default is the value asked for
    kWritten
};

/// A default counts in a message that the world writes, and in the blocks of the root, which each
/// world has. A setting without a value has to be written.
[[nodiscard]] SettingUse use_of(const proto::config::Config& world, const ConfigSetting& setting);

}  // namespace zoned::lint
