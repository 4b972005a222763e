// Inbox: applies the requests of clients to the zone in the recorded order.
#pragma once

#include "server/zone/zone_state.h"

#include <span>

namespace zoned::zone {

/// Applies all items and the rules' messages from other zones. Items for clients that are not here
/// are counted, not obeyed.
std::uint32_t apply_inbox(ZoneState& state, std::span<const mailbox::InboxItem> inbox);

/// Viewers see all at rest; bodies keep their motion.
void rest_all(ZoneState& state);

}  // namespace zoned::zone
