// DeviceTable: a table of the caller's on a device, sent only where it changed.
#pragma once

#include "server/compute/device.h"
#include "server/compute/host_block.h"

#include <cstddef>
#include <optional>

namespace zoned::compute {

/// Keeps a copy in memory that a device may work in: the caller's memory need not begin on a page
/// nor outlive the step.
class DeviceTable {
  public:
    /// The device has the table's bytes; none is allowed, so that a kernel has an argument.
    Status set(Device& device, const void* table, std::size_t bytes);

    /// The same for a table that kernels write into: it is sent whether it changed or not.
    Status clear(Device& device, const void* table, std::size_t bytes);

    [[nodiscard]] const Buffer& buffer() const { return *buffer_; }

    [[nodiscard]] HostBlock& block() { return block_; }

  private:
    Status send(Device& device, const void* table, std::size_t bytes, bool unless_same);

    HostBlock block_;
    std::optional<Buffer> buffer_;
};

}  // namespace zoned::compute
