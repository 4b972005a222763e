// Zone snapshot: all of a zone's state that later ticks depend on, as it lies between two ticks.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::zone {

/// A part that has no saved form fails the archive with its place and the reason.
void save_zone(const ZoneState& state, core::FieldWriter& archive);

/// Into a zone of the same settings that has not ticked yet, with the tick of the snapshot and with
/// maps of paths whose doors are as they were then. After a fault of the archive the zone
/// is of no use. The zone then goes on bit for bit, given the same items and neighbours. Scratch,
/// the matcher's tables and maps of the ground are not saved: they are made anew.
void load_zone(ZoneState& state, core::FieldReader& archive);

}  // namespace zoned::zone
