// Audit: computes the knowledge that one client ought to have by brute force over raw state, apart
// from the tables that it checks.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Notes whose radii are others than a tick ago; to be called in every tick before audit().
void follow_radii(ZoneState& state);

/// True when this client's record is due: periodically (spread over the clients), or because it
/// asked.
bool audit_due(const ZoneState& state, const ZoneClient& client);

/// The record for one client at state.now; entities ascend by id.
mailbox::AuditRecord audit(const ZoneState& state,
                           const RulesContext& context,
                           const ZoneClient& client);

}  // namespace zoned::zone
