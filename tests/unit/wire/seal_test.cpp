#include "shared/wire/seal.h"

#include "shared/core/hex.h"
#include "shared/core/rng.h"
#include "shared/wire/packet.h"

#include <gtest/gtest.h>
#include <openssl/crypto.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <new>
#include <set>
#include <sstream>
#include <string>

namespace zoned::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

// OpenSSL's allocations are counted; this must be arranged before it allocates for the first time.
std::size_t g_allocations = 0;

void* counted_malloc(std::size_t size, const char*, int) {
    ++g_allocations;
    return std::malloc(size);
}

void* counted_realloc(void* p, std::size_t size, const char*, int) {
    ++g_allocations;
    return std::realloc(p, size);
}

void counted_free(void* p, const char*, int) {
    std::free(p);
}

const bool g_counting =
    CRYPTO_set_mem_functions(counted_malloc, counted_realloc, counted_free) == 1;

SealKey sample_key() {
    SealKey key;
    for (std::size_t i = 0; i < key.key.size(); ++i) {
        key.key[i] = static_cast<std::uint8_t>(i * 7 + 1);
    }
    for (std::size_t i = 0; i < key.salt.size(); ++i) {
        key.salt[i] = static_cast<std::uint8_t>(i * 11 + 3);
    }
    return key;
}

Bytes random_bytes(core::Rng& rng, std::size_t size) {
    Bytes out(size);
    for (std::uint8_t& b : out) {
        b = static_cast<std::uint8_t>(rng.below(256));
    }
    return out;
}

/// One line of the vectors: key, nonce, associated data, plain text, cipher text, tag.
struct Vector {
    std::string name;
    Bytes key, nonce, associated, plain, cipher, tag;
};

std::vector<Vector> read_vectors() {
    std::ifstream in(ZONED_SOURCE_DIR "/tests/conformance/aes_128_gcm.txt");
    std::vector<Vector> out;
    std::string line;
    while (std::getline(in, line)) {
        if (line.empty() || line[0] == '#') {
            continue;
        }
        std::istringstream words(line);
        std::array<std::string, 7> w;
        for (std::string& word : w) {
            words >> word;
            if (word == "-") {
                word.clear();
            }
        }
        out.push_back({w[0],
                       *core::from_hex(w[1]),
                       *core::from_hex(w[2]),
                       *core::from_hex(w[3]),
                       *core::from_hex(w[4]),
                       *core::from_hex(w[5]),
                       *core::from_hex(w[6])});
    }
    return out;
}

TEST(Seal, GivesThePublishedAnswersOfAes128Gcm) {
    const auto vectors = read_vectors();
    ASSERT_GE(vectors.size(), 4u);
    for (const Vector& v : vectors) {
        SealKey key;
        ASSERT_EQ(v.key.size(), key.key.size()) << v.name;
        ASSERT_EQ(v.nonce.size(), key.salt.size()) << v.name;
        std::copy(v.key.begin(), v.key.end(), key.key.begin());
        std::copy(v.nonce.begin(), v.nonce.end(), key.salt.begin());
        // With sequence 0 the nonce is the salt; with sequence s it is the salt XOR s.
        for (const std::uint64_t sequence : {std::uint64_t{0}, std::uint64_t{0x0123456789ABCDEF}}) {
            SealKey shifted = key;
            for (std::size_t i = 0; i < 8; ++i) {
                shifted.salt[11 - i] =
                    static_cast<std::uint8_t>(shifted.salt[11 - i] ^ (sequence >> (8 * i)));
            }
            Seal seal(shifted);
            Bytes out{0x77};
            seal.seal(sequence, v.associated, v.plain, out);
            Bytes expected{0x77};
            expected.insert(expected.end(), v.cipher.begin(), v.cipher.end());
            expected.insert(expected.end(), v.tag.begin(), v.tag.end());
            EXPECT_EQ(out, expected) << v.name;
            Bytes plain;
            EXPECT_TRUE(seal.open(sequence, v.associated, std::span(out).subspan(1), plain));
            EXPECT_EQ(plain, v.plain) << v.name;
        }
    }
}

TEST(SealKey, LeavesNothingOfItselfBehind) {
    alignas(SealKey) std::array<unsigned char, sizeof(SealKey)> place;
    place.fill(0xA5);
    auto* key = new (place.data()) SealKey();
    key->key.fill(0x5A);
    key->salt.fill(0x5A);
    key->~SealKey();
    EXPECT_EQ(std::count(place.begin(), place.end(), 0x5A), 0);
}

TEST(Seal, OpensWhatItSealedInAnyOrder) {
    core::Rng rng(1);
    Seal sender(sample_key());
    Seal receiver(sample_key());
    std::vector<std::tuple<std::uint64_t, Bytes, Bytes, Bytes>> sent;
    for (std::uint64_t i = 1; i <= 300; ++i) {
        Bytes associated = random_bytes(rng, kDatagramHeaderBytes);
        Bytes plain = random_bytes(rng, rng.below(1179));
        Bytes sealed;
        sender.seal(i << rng.below(40), associated, plain, sealed);
        (void)sealed;
        sealed.clear();
        sender.seal(i, associated, plain, sealed);
        sent.emplace_back(i, associated, plain, sealed);
    }
    Bytes opened;
    for (std::size_t k = 0; k < sent.size(); ++k) {
        const auto& [sequence, associated, plain, sealed] = sent[(k * 77) % sent.size()];
        ASSERT_TRUE(receiver.open(sequence, associated, sealed, opened));
        ASSERT_EQ(opened, plain);
    }
}

TEST(Seal, RefusesEverySingleFlippedBit) {
    core::Rng rng(2);
    Seal seal(sample_key());
    const Bytes associated = random_bytes(rng, kDatagramHeaderBytes);
    const Bytes plain = random_bytes(rng, 100);
    Bytes sealed;
    seal.seal(42, associated, plain, sealed);
    Bytes opened{1, 2, 3};
    for (std::size_t bit = 0; bit < sealed.size() * 8; ++bit) {
        Bytes bad = sealed;
        bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << (bit % 8)));
        ASSERT_FALSE(seal.open(42, associated, bad, opened));
        ASSERT_TRUE(opened.empty());
    }
    for (std::size_t bit = 0; bit < associated.size() * 8; ++bit) {
        Bytes bad = associated;
        bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << (bit % 8)));
        ASSERT_FALSE(seal.open(42, bad, sealed, opened));
    }
    for (int bit = 0; bit < 64; ++bit) {
        ASSERT_FALSE(seal.open(42 ^ (1ull << bit), associated, sealed, opened));
    }
    for (std::size_t size = 0; size < sealed.size(); ++size) {
        ASSERT_FALSE(seal.open(42, associated, std::span(sealed).first(size), opened));
    }
    for (std::size_t bit = 0; bit < 128; ++bit) {
        SealKey other = sample_key();
        other.key[bit / 8] = static_cast<std::uint8_t>(other.key[bit / 8] ^ (1u << (bit % 8)));
        ASSERT_FALSE(Seal(other).open(42, associated, sealed, opened));
    }
    ASSERT_TRUE(seal.open(42, associated, sealed, opened)) << "failures leave no trace";
    EXPECT_EQ(opened, plain);
}

TEST(Seal, AllocatesNothingAfterConstruction) {
    ASSERT_TRUE(g_counting) << "OpenSSL allocated before the test could count";
    core::Rng rng(3);
    Seal seal(sample_key());
    const Bytes associated = random_bytes(rng, kDatagramHeaderBytes);
    const Bytes plain = random_bytes(rng, 1'000);
    Bytes sealed;
    Bytes opened;
    sealed.reserve(2'000);
    opened.reserve(2'000);
    const std::size_t before = g_allocations;
    EXPECT_GT(before, 0u);
    for (std::uint64_t i = 1; i <= 1'000; ++i) {
        sealed.clear();
        seal.seal(i, associated, plain, sealed);
        ASSERT_TRUE(seal.open(i, associated, sealed, opened));
        ASSERT_FALSE(seal.open(i + 1, associated, sealed, opened));
    }
    EXPECT_EQ(g_allocations, before);
    EXPECT_EQ(sealed.capacity(), 2'000u);
}

TEST(ReplayWindow, AgreesWithASetOfAllThatWasMarked) {
    core::Rng rng(4);
    for (int round = 0; round < 20; ++round) {
        ReplayWindow window;
        std::set<std::uint64_t> marked;
        std::uint64_t front = 1;
        EXPECT_FALSE(window.fresh(0));
        for (int i = 0; i < 10'000; ++i) {
            const std::uint32_t jump = rng.below(200);
            front += jump == 0 ? rng.below(3'000) : jump < 10 ? rng.below(100) : rng.below(3);
            const std::uint64_t sequence =
                front - std::min<std::uint64_t>(rng.below(1'100), front - 1);
            const std::uint64_t newest = marked.empty() ? 0 : *marked.rbegin();
            const bool fresh =
                !marked.contains(sequence) && (sequence > newest || newest - sequence < 1'024);
            ASSERT_EQ(window.fresh(sequence), fresh) << sequence << " after " << newest;
            if (fresh) {
                window.mark(sequence);
                marked.insert(sequence);
                ASSERT_FALSE(window.fresh(sequence));
            }
            ASSERT_EQ(window.newest(), *marked.rbegin());
        }
    }
}

TEST(ReplayWindow, SurvivesTheEndsOfTheRangeOfSequences) {
    ReplayWindow window;
    const std::uint64_t last = ~std::uint64_t{0};
    EXPECT_TRUE(window.fresh(last));
    window.mark(last);
    EXPECT_FALSE(window.fresh(last));
    EXPECT_TRUE(window.fresh(last - 1));
    EXPECT_TRUE(window.fresh(last - 1'023));
    EXPECT_FALSE(window.fresh(last - 1'024));
    EXPECT_FALSE(window.fresh(1));
    window.mark(1);
    EXPECT_EQ(window.newest(), last) << "what is too old changes nothing";
}

}  // namespace
}  // namespace zoned::wire
