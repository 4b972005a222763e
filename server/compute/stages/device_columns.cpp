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
    return buffer_->give(rows(count));
}

Status DeviceColumns::take(std::size_t count) {
    return buffer_->take(rows(count));
}

Status DeviceColumns::take_unchanged() {
    return buffer_->take(Buffer::Rows());
}

Status DeviceColumns::settle() {
    buffer_->settle();
    return Done{};
}

}  // namespace zoned::compute
