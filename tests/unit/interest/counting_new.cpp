#include "tests/unit/interest/counting_new.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::uint64_t> g_allocations{0};

}  // namespace

// Replacements stand in a file of their own, so that no caller inlines one half of a pair.
// NOLINTBEGIN
void* operator new(std::size_t size) {
    ++g_allocations;
    if (void* p = std::malloc(size == 0 ? 1 : size)) {
        return p;
    }
    throw std::bad_alloc();
}

void operator delete(void* p) noexcept {
    std::free(p);
}

void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}

// NOLINTEND

std::uint64_t zoned::testing_support::allocations() {
    return g_allocations;
}
