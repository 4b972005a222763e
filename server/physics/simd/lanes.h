// Lanes: eight numbers at once, and the moves between rows of eight and lanes; the arithmetic of
// the wide solver.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace zoned::physics {

inline constexpr std::size_t kLanes = 8;

/// One number of each of eight constraints, as the vector type of both compilers: they turn it into
/// whatever registers the target has. Fixed-size Eigen arrays in structures as large as the
/// solver's stay in memory between operations (measured: four times slower).
typedef float Lanes __attribute__((vector_size(32)));

#define ZONED_INLINE [[gnu::always_inline]] inline

/// Before a loop over lanes or points: unrolls its body, so that its values stay in registers.
/// (clang++ does so by itself.)
#if defined(__clang__)
#define ZONED_UNROLL
#else
#define ZONED_UNROLL _Pragma("GCC unroll 8")
#endif

ZONED_INLINE Lanes lanes(float value) {
    return Lanes{value, value, value, value, value, value, value, value};
}

ZONED_INLINE Lanes min(const Lanes& a, const Lanes& b) {
    return a < b ? a : b;
}

ZONED_INLINE Lanes max(const Lanes& a, const Lanes& b) {
    return a > b ? a : b;
}

/// Rounded correctly, as std::sqrt is. (Eigen's packet version starts from the processor's
/// approximation of 1 / sqrt, which differs between makers.)
ZONED_INLINE Lanes sqrt(const Lanes& a) {
#ifdef __AVX__
    return __builtin_ia32_sqrtps256(a);
#else
    Lanes out{};
    ZONED_UNROLL
    for (std::size_t i = 0; i < kLanes; ++i) {
        out[i] = std::sqrt(a[i]);
    }
    return out;
#endif
}

/// Eight numbers in a row, wherever they lie.
ZONED_INLINE Lanes load(const float* p) {
    Lanes out;
    std::memcpy(&out, p, sizeof(out));
    return out;
}

ZONED_INLINE float lowest_of(const Lanes& a) {
    const Lanes b = min(a, __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3));
    const Lanes c = min(b, __builtin_shufflevector(b, b, 2, 3, 0, 1, 6, 7, 4, 5));
    return c[0] < c[1] ? c[0] : c[1];
}

ZONED_INLINE float sum_of(const Lanes& a) {
    const Lanes b = a + __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3);
    const Lanes c = b + __builtin_shufflevector(b, b, 2, 3, 0, 1, 6, 7, 4, 5);
    return c[0] + c[1];
}

/// Whether a comparison holds in any lane.
template <class Mask>
ZONED_INLINE bool any(const Mask& mask) {
    const Mask a = mask | __builtin_shufflevector(mask, mask, 4, 5, 6, 7, 0, 1, 2, 3);
    const Mask b = a | __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5);
    return (b[0] | b[1]) != 0;
}

/// `value` in the lanes where `s` is not positive, zero in the others.
ZONED_INLINE Lanes where_not_positive(const Lanes& s, const Lanes& value) {
    return s <= lanes(0.0F) ? value : lanes(0.0F);
}

/// One vector of each of eight constraints.
struct Lanes3 {
    Lanes x{}, y{}, z{};

    void set(std::size_t lane, const Vec3& v) {
        x[lane] = v.x();
        y[lane] = v.y();
        z[lane] = v.z();
    }

    [[nodiscard]] Vec3 get(std::size_t lane) const { return {x[lane], y[lane], z[lane]}; }
};

ZONED_INLINE Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

ZONED_INLINE Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

ZONED_INLINE Lanes3 operator*(const Lanes& s, const Lanes3& v) {
    return {s * v.x, s * v.y, s * v.z};
}

ZONED_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

ZONED_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Eight symmetric 3 x 3 matrices.
struct LanesTensor {
    Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
};

ZONED_INLINE Lanes3 operator*(const LanesTensor& m, const Lanes3& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z,
            m.xy * v.x + m.yy * v.y + m.yz * v.z,
            m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

/// Eight numbers of one body. A constraint takes the body's numbers in whole rows, so that eight
/// rows become eight lanes by one transposition.
struct Row8 {
    Lanes at{};

    template <class Archive>
    void serialize(Archive& archive) {
        for (std::size_t i = 0; i < 8; ++i) {
            float number = at[i];
            archive(number);
            at[i] = number;
        }
    }
};

using LaneRows = std::array<std::uint32_t, kLanes>;

/// Eight times eight numbers.
struct Block8 {
    Lanes row[kLanes];
};

/// Rows become columns.
ZONED_INLINE void transpose(Block8& m) {
    Block8 t;
    ZONED_UNROLL
    for (std::size_t i = 0; i < kLanes; i += 2) {
        const Lanes& a = m.row[i];
        const Lanes& b = m.row[i + 1];
        t.row[i] = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
        t.row[i + 1] = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    }
    Block8 u;
    ZONED_UNROLL
    for (std::size_t i = 0; i < kLanes; i += 4) {
        u.row[i] = __builtin_shufflevector(t.row[i], t.row[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        u.row[i + 1] = __builtin_shufflevector(t.row[i], t.row[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        u.row[i + 2] =
            __builtin_shufflevector(t.row[i + 1], t.row[i + 3], 0, 1, 8, 9, 4, 5, 12, 13);
        u.row[i + 3] =
            __builtin_shufflevector(t.row[i + 1], t.row[i + 3], 2, 3, 10, 11, 6, 7, 14, 15);
    }
    ZONED_UNROLL
    for (std::size_t i = 0; i < 4; ++i) {
        m.row[i] = __builtin_shufflevector(u.row[i], u.row[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        m.row[i + 4] = __builtin_shufflevector(u.row[i], u.row[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

/// Row `rows[i]` of the table becomes lane i of the eight results.
ZONED_INLINE Block8 gather(const Row8* table, const LaneRows& rows) {
    Block8 block;
    ZONED_UNROLL
    for (std::size_t i = 0; i < kLanes; ++i) {
        block.row[i] = table[rows[i]].at;
    }
    transpose(block);
    return block;
}

#undef ZONED_INLINE

}  // namespace zoned::physics
