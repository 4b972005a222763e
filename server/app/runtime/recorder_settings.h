// Recorder settings: what a server records by its config, and where.
#pragma once

#include "server/config/settings.h"
#include "server/recording/recorder.h"

#include <string>

namespace zoned::app {

/// The recording of the whole run and the last inputs, as the config asks for them.
recording::RecorderSettings recorder_settings(const config::Settings& settings);

/// A file of the state folder; without a name the time is one.
std::string recording_path(const config::Settings& settings, const std::string& name);

}  // namespace zoned::app
