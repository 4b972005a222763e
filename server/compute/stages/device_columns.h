// DeviceColumns: columns of floats on a device.
#pragma once

#include "server/compute/device.h"
#include "server/compute/stages/particle_stage.h"

#include <initializer_list>
#include <memory>
#include <optional>

namespace zoned::compute {

/// The first result that is not done, or done. A list is worked off from left to right, and after a
/// failure every call on a device fails at once: so lists of calls read like the order of a step.
Status first_failure(std::initializer_list<Status> steps);

/// A buffer over a block of columns, made anew where they grow; the block lives as long as it.
class DeviceColumns {
  public:
    Status hold(Device& device, ParticleColumns& columns);

    /// The device gets the first `count` of each column.
    Status give(std::size_t count);
    /// They are being transferred back: Device::finish(), then settle().
    Status take(std::size_t count);
    /// The host may touch them again; the device did not change them.
    Status take_unchanged();
    Status settle();

    [[nodiscard]] const Buffer& buffer() const { return *buffer_; }

  private:
    [[nodiscard]] Buffer::Rows rows(std::size_t count) const {
        return {count * sizeof(float), stride_, ParticleColumns::kColumns};
    }

    std::shared_ptr<HostBlock> block_;
    std::optional<Buffer> buffer_;
    std::size_t stride_ = 0;
};

}  // namespace zoned::compute
