#include "shared/wire/seal.h"

namespace zoned::wire {
namespace {

constexpr std::uint64_t kWindow = 1024;

std::uint64_t bit_of(std::uint64_t sequence) {
    return std::uint64_t{1} << (sequence % 64);
}

std::size_t word_of(std::uint64_t sequence) {
    return static_cast<std::size_t>(sequence % kWindow / 64);
}

}  // namespace

bool ReplayWindow::fresh(std::uint64_t sequence) const {
    static_assert(kWords * 64 == kWindow);
    if (sequence == 0) {
        return false;  // Sequences start at 1.
    }
    if (sequence > newest_) {
        return true;
    }
    return newest_ - sequence < kWindow && (seen_[word_of(sequence)] & bit_of(sequence)) == 0;
}

void ReplayWindow::mark(std::uint64_t sequence) {
    if (sequence == 0 || (sequence <= newest_ && newest_ - sequence >= kWindow)) {
        return;
    }
    if (sequence > newest_) {
        if (sequence - newest_ >= kWindow) {
            seen_.fill(0);
        } else {
            // The bits of the sequences in between still speak of those one window ago.
            for (std::uint64_t s = newest_ + 1; s < sequence; ++s) {
                seen_[word_of(s)] &= ~bit_of(s);
            }
        }
        newest_ = sequence;
    }
    seen_[word_of(sequence)] |= bit_of(sequence);
}

}  // namespace zoned::wire
