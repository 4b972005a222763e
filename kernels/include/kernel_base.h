// Kernel base: macros that compile one source as OpenCL C and as C++, for one number or for eight.
#pragma once

// A shared function is written once over `Real`. In OpenCL C `Real` is float, or float8 where the
// program says ZK_WIDE before it includes anything. In C++ it is a template parameter, float or
// Lanes. The operations and their order are those of the text in all four. Neither side may
// contract, reorder or approximate them, so that the results are the same bit for bit.

#ifdef __OPENCL_C_VERSION__

#pragma OPENCL FP_CONTRACT OFF

#ifdef ZK_WIDE
#define Real float8
#define ZK_INT int8
#define zk_to_int(x) convert_int8_rtz(x)
#define zk_to_real(x) convert_float8(x)
#define zk_gather(table, index)    \
    ((float8)((table)[(index).s0], \
              (table)[(index).s1], \
              (table)[(index).s2], \
              (table)[(index).s3], \
              (table)[(index).s4], \
              (table)[(index).s5], \
              (table)[(index).s6], \
              (table)[(index).s7]))
#else
#define Real float
#define ZK_INT int
#define zk_to_int(x) convert_int_rtz(x)
#define zk_to_real(x) convert_float(x)
#define zk_gather(table, index) ((table)[index])
#endif

#define ZK_BEGIN
#define ZK_END
#define ZK_FN static inline
#define ZK_REAL_FN static inline
#define ZK_REAL_STRUCT
#define ZK_OF_REAL(T) T
#define ZK_MASK ZK_INT
#define ZK_GLOBAL __global
/// Where small tables lie: a choice of the program's options.
#ifdef ZK_TABLES_IN_GLOBAL_MEMORY
#define ZK_TABLE __global
#else
#define ZK_TABLE __constant
#endif
#define zk_sqrt(x) sqrt(x)
#define zk_pick(mask, a, b) ((mask) ? (a) : (b))
#define zk_splat(x) ((Real)(x))

#else

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#define ZK_BEGIN namespace zoned::kernels {
#define ZK_END }
#define ZK_FN [[gnu::always_inline]] inline
#define ZK_REAL_FN        \
    template <class Real> \
    [[gnu::always_inline]] inline
#define ZK_REAL_STRUCT template <class Real>
#define ZK_OF_REAL(T) T<Real>
#define ZK_INT typename ::zoned::kernels::IntsOf<Real>::Type
#define ZK_MASK typename ::zoned::kernels::IntsOf<Real>::Type
#define ZK_GLOBAL
#define ZK_TABLE
#define zk_splat(x) (Real{} + (x))

namespace zoned::kernels {

/// Eight numbers at once, as the vector type of both compilers: in whatever registers there are.
typedef float Lanes __attribute__((vector_size(32)));
typedef std::int32_t LaneInts __attribute__((vector_size(32)));

inline constexpr std::size_t kLanes = 8;

template <class Real>
struct IntsOf;

template <>
struct IntsOf<float> {
    using Type = std::int32_t;
};

template <>
struct IntsOf<Lanes> {
    using Type = LaneInts;
};

ZK_FN float zk_sqrt(float x) {
    return std::sqrt(x);
}

/// Rounded correctly, as std::sqrt is.
ZK_FN Lanes zk_sqrt(const Lanes& x) {
#ifdef __AVX__
    return __builtin_ia32_sqrtps256(x);
#else
    Lanes out{};
    for (std::size_t i = 0; i < kLanes; ++i) {
        out[i] = std::sqrt(x[i]);
    }
    return out;
#endif
}

ZK_FN float zk_pick(bool mask, float a, float b) {
    return mask ? a : b;
}

ZK_FN std::int32_t zk_pick(bool mask, std::int32_t a, std::int32_t b) {
    return mask ? a : b;
}

ZK_FN Lanes zk_pick(const LaneInts& mask, const Lanes& a, const Lanes& b) {
    return mask ? a : b;
}

ZK_FN LaneInts zk_pick(const LaneInts& mask, const LaneInts& a, const LaneInts& b) {
    return mask ? a : b;
}

/// Towards zero; |x| < 2^31.
ZK_FN std::int32_t zk_to_int(float x) {
    return static_cast<std::int32_t>(x);
}

ZK_FN LaneInts zk_to_int(const Lanes& x) {
    return __builtin_convertvector(x, LaneInts);
}

ZK_FN float zk_to_real(std::int32_t x) {
    return static_cast<float>(x);
}

ZK_FN Lanes zk_to_real(const LaneInts& x) {
    return __builtin_convertvector(x, Lanes);
}

ZK_FN float zk_gather(const float* table, std::int32_t index) {
    return table[index];
}

ZK_FN Lanes zk_gather(const float* table, const LaneInts& index) {
    Lanes out{};
    for (std::size_t i = 0; i < kLanes; ++i) {
        out[i] = table[index[i]];
    }
    return out;
}

ZK_FN Lanes zk_load(const float* p) {
    Lanes out;
    std::memcpy(&out, p, sizeof(out));
    return out;
}

ZK_FN void zk_store(float* p, const Lanes& value) {
    std::memcpy(p, &value, sizeof(value));
}

}  // namespace zoned::kernels

#endif

ZK_BEGIN

/// The largest whole number not above x, for |x| < 2^31.
ZK_REAL_FN Real zk_floor(const Real x) {
    const Real cut = zk_to_real(zk_to_int(x));
    return zk_pick(x < cut, cut - 1.0f, cut);
}

/// `low` for NaN: a clamped number may become an index.
ZK_REAL_FN Real zk_clamp(const Real x, const Real low, const Real high) {
    return zk_pick(x > low, zk_pick(x < high, x, high), low);
}

ZK_END
