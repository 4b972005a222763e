// SnapshotRun: a world with bots, of which copies are made by snapshots and fed the same items.
#pragma once

#include "client-sim/app/swarm.h"
#include "tests/harness/virtual_server.h"
#include "shared/core/archive/field_archive.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace zoned::snapshot {

/// How a world is run, and how long copies follow it.
struct SnapshotCourse {
    std::string config;  ///< a file's path, or its text
    bool config_is_text = false;
    std::vector<std::string> sets;
    std::size_t bots = 4;
    Tick first = 20;  ///< tick of the first snapshot, which a seed delays a little
    Tick every = 60;  ///< ticks from one snapshot to the next
    int snapshots = 3;
    Tick follows = 60;         ///< ticks that a copy goes on for
    int longest_refusal = 60;  ///< ticks in a row in which the world may refuse to be saved
    std::uint64_t seed = 1;
};

struct SnapshotResult {
    std::string wrong;  ///< the first difference; empty: there is none
    std::size_t copies = 0;
    std::size_t compared = 0;  ///< hashes of zones
    int refused = 0;           ///< most ticks in a row in which there was no saved form
    std::size_t most_bytes = 0;
    double save_ms = 0.0;                        ///< the shortest: other work disturbs the rest
    double load_ms = 0.0;                        ///< likewise, with the making of the world
    std::vector<core::ArchiveSection> sections;  ///< of the last snapshot
};

/// Runs the course. A copy is a fresh world of the same config that has loaded a snapshot: it must
/// give the same bytes when it is saved again at once, the same hash of each zone in every tick,
/// and the same bytes at its end.
SnapshotResult run_course(const SnapshotCourse& course);

/// The parts in which two snapshots differ, by their names; empty: they are equal.
std::string differences(const std::vector<std::uint8_t>& a,
                        const std::vector<core::ArchiveSection>& parts_of_a,
                        const std::vector<std::uint8_t>& b,
                        const std::vector<core::ArchiveSection>& parts_of_b);

}  // namespace zoned::snapshot
