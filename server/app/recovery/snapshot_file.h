// Snapshot files: a run between two ticks on disk, whole or not at all.
#pragma once

#include "server/app/recovery/run_ledger.h"
#include "server/app/world/world.h"
#include "shared/core/result.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::app {

struct SnapshotFile {
    Tick tick = 0;
    std::string path;
};

/// The snapshots in a folder, the newest first. Files that are not whole are none.
std::vector<SnapshotFile> snapshots_in(const std::string& folder);

/// Writes, syncs, renames: what has the name of a snapshot is one. `buffer` is scratch. Empty text:
/// done; otherwise the reason, a part of the world that has no saved form among them.
std::string write_snapshot(const std::string& folder,
                           const World& world,
                           const RunLedger& ledger,
                           std::vector<std::uint8_t>& buffer);

/// The bytes of a snapshot. Fails where the file cannot be read or is damaged.
core::Result<std::vector<std::uint8_t>> read_snapshot(const SnapshotFile& file);

/// Into a world of the same build and config that has not ticked yet. Empty text: done.
std::string load_snapshot(const std::vector<std::uint8_t>& bytes, World& world, RunLedger& ledger);

/// Removes the snapshots of ticks before this one, and pieces that were not finished.
void remove_snapshots_before(const std::string& folder, Tick tick);

}  // namespace zoned::app
