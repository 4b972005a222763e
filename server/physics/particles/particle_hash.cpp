// The state hash of particles: their columns, in streams side by side, since there may be millions.
#include "server/physics/particles/particle_system.h"

#include <array>
#include <bit>
#include <cstring>

namespace zoned::physics {

namespace {

constexpr std::size_t kStreams = 8;

/// Eight streams of multiply and rotate, folded by the state hash: a stream alone would wait for
/// its product at each word. A word changes its stream's value one to one, so that a difference in
/// one word always shows.
void hash_words(core::StateHash& hash, const void* data, std::size_t words) {
    std::array<std::uint64_t, kStreams> streams{};
    const auto* const bytes = static_cast<const char*>(data);
    std::size_t i = 0;
    for (; i + kStreams <= words; i += kStreams) {
        std::array<std::uint64_t, kStreams> w;
        std::memcpy(w.data(), bytes + 8 * i, sizeof(w));
        for (std::size_t s = 0; s < kStreams; ++s) {
            streams[s] = std::rotl((streams[s] ^ w[s]) * 0x9E3779B97F4A7C15ull, 29);
        }
    }
    for (; i < words; ++i) {
        std::uint64_t w = 0;
        std::memcpy(&w, bytes + 8 * i, sizeof(w));
        hash.add(w);
    }
    for (const std::uint64_t s : streams) {
        hash.add(s);
    }
}

}  // namespace

void ParticleSystem::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(size_));
    for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
        if (size_ == 0) {
            break;
        }
        hash_words(hash, columns_.column(c), size_ / 2);
        if (size_ % 2 != 0) {
            hash.add(columns_.column(c)[size_ - 1]);
        }
    }
    hash_words(hash, ends_.data(), ends_.size());
    hash.add(static_cast<std::uint64_t>(emitters_.size()));
    for (const motion::Emitter& emitter : emitters_) {
        hash.add(emitter.seed);
        hash.add(emitter.start);
    }
}

}  // namespace zoned::physics
