#include "shared/core/foreign_handle.h"

#include <utility>

namespace zoned::core {

namespace {

thread_local ForeignHandles* current = nullptr;

}  // namespace

ForeignHandles* ForeignHandles::use(ForeignHandles* list) noexcept {
    return std::exchange(current, list);
}

void ForeignHandles::close_all() noexcept {
    while (first_ != nullptr) {
        ForeignHandle& handle = *first_;
        first_ = handle.next_;
        if (handle.handle_ != nullptr) {
            handle.close_(handle.handle_);
        }
    }
}

ForeignHandle::ForeignHandle(void* handle, Close close) noexcept : handle_(handle), close_(close) {
    if (current == nullptr) {
        return;
    }
    to_this_ = &current->first_;
    next_ = current->first_;
    if (next_ != nullptr) {
        next_->to_this_ = &next_;
    }
    current->first_ = this;
}

ForeignHandle::~ForeignHandle() {
    if (to_this_ != nullptr) {
        *to_this_ = next_;
        if (next_ != nullptr) {
            next_->to_this_ = to_this_;
        }
    }
    if (handle_ != nullptr) {
        close_(handle_);
    }
}

}  // namespace zoned::core
