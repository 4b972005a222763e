// ShootersWorld: the common config text of worlds for tests of shots and trades. Each test adds
// size, entities and rules.
#pragma once

namespace zoned::harness {

/// One zone, players that hear of all others and can be rewound, audits, all rights.
inline constexpr const char* kShootersWorld = R"(
zones { zone_grid { columns: 1 rows: 1 } }
type {
  name: "player" kind: CHARACTER rewindable: true
  capsule { radius_m: 0.4 length_m: 1 }
  mass_kg: 80
  aura_m { normal: 100 } nimbus_m { normal: 100 }
  character { }
}
session { dev_mode_loopback: true dev_rights: [PLAY, AUDIT, FREEZE] }
audit { enabled: true period_ticks: 15 }
)";

}  // namespace zoned::harness
