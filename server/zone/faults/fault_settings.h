// Fault settings: the errors that a zone commits on purpose.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/rng.h"

#include <cstdint>
#include <optional>

namespace zoned::zone {

/// A fault that hits a fixed share of the entities or clients, chosen by a hash of their id.
struct ShareFault {
    double share = 0.0;  ///< [0, 1]; 0 = off
    Tick from_tick = 0;

    [[nodiscard]] bool operator==(const ShareFault&) const = default;

    [[nodiscard]] bool hits(std::uint32_t id, Tick now) const {
        return share > 0.0 && now >= from_tick &&
               static_cast<double>(core::mix(id) >> 11U) * 0x1.0p-53 < share;
    }
};

enum class BreakKind : std::uint8_t {
    kThrow,  ///< the rules throw
    kCrash,  ///< SIGSEGV
    kAbort,  ///< SIGABRT
};

/// Faults on purpose, to check the checkers. All off by default.
struct FaultSettings {
    ShareFault corrupt;             ///< these entities' replicated positions are off ...
    float corrupt_offset_m = 0.0F;  ///< ... by this much
    ShareFault corrupt_field;       ///< clients get other declared fields of these entities
    ShareFault hide;                ///< these entities are kept from everybody
    ShareFault leak;                ///< these viewers hear of one entity beyond their radii
    ShareFault leak_filtered;       ///< these viewers hear of concealed entities
    ShareFault drop_decision;   ///< these clients do not get the decisions that they are to confirm
    Tick stall_from = 0;        ///< this zone does not simulate nor publish from this tick ...
    Tick stall_ticks = 0;       ///< ... for this many
    bool silent_bound = false;  ///< clients are not notified of wider bounds
    std::optional<BreakKind> broken;  ///< the rules of this zone fail ...
    Tick broken_at = 0;               ///< ... in this tick

    [[nodiscard]] bool operator==(const FaultSettings&) const = default;
};

}  // namespace zoned::zone
