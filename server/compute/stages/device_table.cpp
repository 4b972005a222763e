// build: hot loops
#include "server/compute/stages/device_table.h"

#include <algorithm>
#include <cstring>

namespace zoned::compute {

Status DeviceTable::set(Device& device, const void* table, std::size_t bytes) {
    return send(device, table, bytes, true);
}

Status DeviceTable::clear(Device& device, const void* table, std::size_t bytes) {
    return send(device, table, bytes, false);
}

Status DeviceTable::send(Device& device, const void* table, std::size_t bytes, bool unless_same) {
    const bool fresh = !buffer_ || block_.bytes() < bytes;
    if (!fresh && unless_same && (bytes == 0 || std::memcmp(block_.data(), table, bytes) == 0)) {
        return Done{};
    }
    if (fresh) {
        buffer_.reset();
        block_ = HostBlock(std::max<std::size_t>(bytes, 1));
        auto made = Buffer::over(device, block_.data(), block_.bytes());
        if (!made) {
            return Status::failure(made.error());
        }
        buffer_.emplace(std::move(*made));
    } else if (device.buffers() == BufferMode::kMapped) {
        // The block is the device's until it comes back.
        if (Status back = buffer_->take(); !back) {
            return back;
        }
        if (Status waited = device.finish(); !waited) {
            return waited;
        }
    }
    if (bytes > 0) {
        std::memcpy(block_.data(), table, bytes);
    }
    return buffer_->give();
}

}  // namespace zoned::compute
