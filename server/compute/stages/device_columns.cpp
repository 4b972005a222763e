// build: hot loops
#include "server/compute/stages/device_columns.h"

#include <utility>

namespace zoned::compute {

Status first_failure(std::initializer_list<Status> steps) {
    for (const Status& step : steps) {
        if (!step) {
            return step;
        }
    }
    return Done{};
}

Status DeviceColumns::hold(Device& device, ParticleColumns& columns) {
    if (block_ == columns.block()) {
        return Done{};
    }
    buffer_.reset();
    block_ = columns.block();
    stride_ = columns.stride() * sizeof(float);
    auto made = Buffer::over(device, block_->data(), block_->bytes());
    if (!made) {
        block_.reset();
        return Status::failure(made.error());
    }
    buffer_.emplace(std::move(*made));
    return Done{};
}

Status DeviceColumns::give(std::size_t count) {
    for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
        if (Status ok = buffer_->give(c * stride_, count * sizeof(float)); !ok) {
            return ok;
        }
    }
    return Done{};
}

Status DeviceColumns::take(std::size_t count) {
    for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
        if (Status ok = buffer_->take(c * stride_, count * sizeof(float)); !ok) {
            return ok;
        }
    }
    return Done{};
}

Status DeviceColumns::take_unchanged() {
    return buffer_->take(0, 0);
}

Status DeviceColumns::settle() {
    buffer_->settle();
    return Done{};
}

}  // namespace zoned::compute
