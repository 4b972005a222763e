// Agent reload: puts the agents of a config that was read anew into a running world.
#pragma once

#include "server/config/settings.h"
#include "server/mailbox/messages.h"
#include "shared/core/result.h"

#include <string>
#include <vector>

namespace zoned::app {

/// Reads `file` with `sets` as for a start. Fails with all mistakes in it, or with the differences
/// that take a restart; `running` is the config of the running world.
core::Result<mailbox::NewBrains> load_brains(const std::string& file,
                                             const std::vector<std::string>& sets,
                                             const config::Settings& running);

/// Gives an item that comes from a recording the agents that its text says; other items stay.
core::Result<bool> restore_brains(const config::Settings& running, mailbox::InboxItem& item);

}  // namespace zoned::app
