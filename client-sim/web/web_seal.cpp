// wire::Seal where the only streams are WebSockets of a browser: they need no seal, and the module
// no cryptography.
#include "shared/core/assert.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"

#include <algorithm>

namespace zoned::wire {

struct Seal::Contexts {};

Seal::Seal(const SealKey& /*key*/) {
    ZONED_ASSERT(false, "a browser's streams have no keys");
}

bool Seal::usable() const {
    return true;
}

Seal::Seal() = default;
Seal::Seal(Seal&&) noexcept = default;
Seal& Seal::operator=(Seal&&) noexcept = default;
Seal::~Seal() = default;

Seal Seal::none() {
    return {};
}

void Seal::seal(std::uint64_t /*sequence*/,
                std::span<const std::uint8_t> /*associated*/,
                std::span<const std::uint8_t> plain,
                std::vector<std::uint8_t>& out) {
    out.insert(out.end(), plain.begin(), plain.end());
    out.resize(out.size() + kSealTagBytes);
}

bool Seal::open(std::uint64_t /*sequence*/,
                std::span<const std::uint8_t> /*associated*/,
                std::span<const std::uint8_t> sealed,
                std::vector<std::uint8_t>& plain) {
    plain.clear();
    if (sealed.size() < kSealTagBytes) {
        return false;
    }
    const auto tag = sealed.end() - static_cast<std::ptrdiff_t>(kSealTagBytes);
    if (std::any_of(tag, sealed.end(), [](std::uint8_t byte) { return byte != 0; })) {
        return false;
    }
    plain.assign(sealed.begin(), tag);
    return true;
}

}  // namespace zoned::wire
