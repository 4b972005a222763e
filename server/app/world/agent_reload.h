// Agent reload: gives recorded items the agents of a config that was read anew.
#pragma once

#include "server/config/settings.h"
#include "server/mailbox/messages.h"
#include "shared/core/result.h"

namespace zoned::app {

/// Gives an item that comes from a recording the agents that its text says; other items stay.
core::Result<bool> restore_brains(const config::Settings& running, mailbox::InboxItem& item);

}  // namespace zoned::app
