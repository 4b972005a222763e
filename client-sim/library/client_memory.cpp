#include "client-sim/library/client_memory.h"

#include <csetjmp>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <utility>

namespace zoned::library {

namespace {

thread_local ClientMemory* current = nullptr;

}  // namespace

bool ClientMemory::run(void (*work)(void*), void* argument) noexcept {
    before_ = std::exchange(current, this);
    listed_before_ = core::ForeignHandles::use(&handles_);
    std::jmp_buf escape;
    escape_ = &escape;
    // NOLINTNEXTLINE(cert-err52-cpp): without exceptions there is no other way out.
    if (_setjmp(escape) == 0) {
        work(argument);
        leave();
        return true;
    }
    leave();
    give_back();
    return false;
}

void ClientMemory::leave() noexcept {
    current = before_;
    core::ForeignHandles::use(listed_before_);
}

void* ClientMemory::take_link(std::size_t size) noexcept {
    if (size > PTRDIFF_MAX) {
        return nullptr;
    }
    void* const block = allocator_.allocate(allocator_.context, sizeof(Link) + size);
    if (block == nullptr) {
        return nullptr;
    }
    Link* const link = new (block) Link{&links_, links_};
    if (links_ != nullptr) {
        links_->to_this = &link->next;
    }
    links_ = link;
    return link + 1;
}

/// A slab whose rest is too short for this is not used any more.
void* ClientMemory::cut(std::size_t size) noexcept {
    if (slab_left_ < size) {
        auto* const slab = static_cast<std::byte*>(take_link(kSlabBytes));
        if (slab == nullptr) {
            return nullptr;
        }
        slab_ = slab;
        slab_left_ = kSlabBytes;
    }
    slab_left_ -= size;
    return slab_ + slab_left_;
}

void* ClientMemory::take(std::size_t size) noexcept {
    const std::size_t wanted = size + sizeof(Header);
    std::size_t size_class = 0;
    while (size_class < kClasses && kSmallest << size_class < wanted) {
        ++size_class;
    }
    void* block = nullptr;
    if (size_class == kClasses) {
        block = take_link(wanted);
    } else if (free_[size_class] != nullptr) {
        block = free_[size_class];
        free_[size_class] = free_[size_class]->next;
    } else {
        const std::size_t bytes = kSmallest << size_class;
        block = bytes <= kMostCut ? cut(bytes) : take_link(bytes);
    }
    return block != nullptr ? new (block) Header{this, size_class} + 1 : nullptr;
}

void ClientMemory::give(void* block) noexcept {
    if (block == nullptr) {
        return;
    }
    Header* const header = static_cast<Header*>(block) - 1;
    ClientMemory* const owner = header->owner;
    if (owner == nullptr) {
        std::free(header);
        return;
    }
    const std::size_t size_class = header->size_class;
    if (size_class == kClasses) {
        Link* const link = static_cast<Link*>(static_cast<void*>(header)) - 1;
        *link->to_this = link->next;
        if (link->next != nullptr) {
            link->next->to_this = link->to_this;
        }
        owner->allocator_.release(owner->allocator_.context, link);
        return;
    }
    owner->free_[size_class] = new (header) Free{owner->free_[size_class]};
}

void ClientMemory::give_back() noexcept {
    handles_.close_all();
    while (links_ != nullptr) {
        Link* const link = links_;
        links_ = link->next;
        allocator_.release(allocator_.context, link);
    }
    free_.fill(nullptr);
    slab_left_ = 0;
}

void* ClientMemory::try_current(std::size_t size) noexcept {
    if (current != nullptr) {
        return current->take(size);
    }
    // While the library is loaded.
    void* const block = std::malloc(size + sizeof(Header));
    return block != nullptr ? new (block) Header{} + 1 : nullptr;
}

void* ClientMemory::take_current(std::size_t size) noexcept {
    void* const block = try_current(size);
    if (block == nullptr && current == nullptr) {
        std::abort();
    }
    if (block == nullptr) {
        // NOLINTNEXTLINE(cert-err52-cpp)
        _longjmp(*static_cast<std::jmp_buf*>(current->escape_), 1);
    }
    return block;
}

}  // namespace zoned::library

using zoned::library::ClientMemory;

void* operator new(std::size_t size) {
    return ClientMemory::take_current(size);
}

void* operator new[](std::size_t size) {
    return ClientMemory::take_current(size);
}

void* operator new(std::size_t size, const std::nothrow_t& /*unused*/) noexcept {
    return ClientMemory::try_current(size);
}

void* operator new[](std::size_t size, const std::nothrow_t& /*unused*/) noexcept {
    return ClientMemory::try_current(size);
}

void operator delete(void* block) noexcept {
    ClientMemory::give(block);
}

void operator delete[](void* block) noexcept {
    ClientMemory::give(block);
}

void operator delete(void* block, std::size_t /*size*/) noexcept {
    ClientMemory::give(block);
}

void operator delete[](void* block, std::size_t /*size*/) noexcept {
    ClientMemory::give(block);
}
