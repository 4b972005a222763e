// Array8: eight numbers that are computed with at once, each as if it were alone: the same bits on
// all processors, whatever their registers hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace zoned {

/// The vector type of both compilers, which turn it into the registers that there are. (Eigen's
/// arrays depend on their width: reductions take another order, roots are approximations.)
class Array8 {
  public:
    typedef float Numbers __attribute__((vector_size(32)));
    typedef std::int32_t Integers __attribute__((vector_size(32)));

    /// The outcome of a comparison.
    struct Mask {
        Integers bits;

        [[nodiscard, gnu::always_inline]] Array8 select(const Array8& yes, const Array8& no) const {
            return bits ? yes.numbers_ : no.numbers_;
        }

        [[nodiscard, gnu::always_inline]] Integers select(const Integers& yes,
                                                          const Integers& no) const {
            return bits ? yes : no;
        }
    };

    Array8() = default;

    /// The same number eight times.
    [[gnu::always_inline]] Array8(float all) : numbers_{all, all, all, all, all, all, all, all} {}

    [[gnu::always_inline]] Array8(const Numbers& numbers) : numbers_(numbers) {}

    /// Eight numbers in a row, wherever they lie.
    [[gnu::always_inline]] static Array8 load(const float* from) {
        Array8 out;
        std::memcpy(&out.numbers_, from, sizeof(out.numbers_));
        return out;
    }

    [[gnu::always_inline]] void store(float* to) const {
        std::memcpy(to, &numbers_, sizeof(numbers_));
    }

    [[nodiscard, gnu::always_inline]] const float* data() const {
        return reinterpret_cast<const float*>(&numbers_);
    }

    [[gnu::always_inline]] float operator[](std::ptrdiff_t i) const { return data()[i]; }

    [[gnu::always_inline]] float& operator[](std::ptrdiff_t i) {
        return reinterpret_cast<float*>(&numbers_)[i];
    }

    [[gnu::always_inline]] friend Array8 operator+(const Array8& a, const Array8& b) {
        return a.numbers_ + b.numbers_;
    }

    [[gnu::always_inline]] friend Array8 operator-(const Array8& a, const Array8& b) {
        return a.numbers_ - b.numbers_;
    }

    [[gnu::always_inline]] friend Array8 operator*(const Array8& a, const Array8& b) {
        return a.numbers_ * b.numbers_;
    }

    [[gnu::always_inline]] friend Array8 operator/(const Array8& a, const Array8& b) {
        return a.numbers_ / b.numbers_;
    }

    [[gnu::always_inline]] friend Array8 operator-(const Array8& a) { return -a.numbers_; }

    [[gnu::always_inline]] Array8& operator+=(const Array8& other) {
        numbers_ = numbers_ + other.numbers_;
        return *this;
    }

    [[gnu::always_inline]] friend Mask operator>(const Array8& a, const Array8& b) {
        return {a.numbers_ > b.numbers_};
    }

    /// Where one of the two is not a number: this one.
    [[nodiscard, gnu::always_inline]] Array8 min(const Array8& other) const {
        return other.numbers_ < numbers_ ? other.numbers_ : numbers_;
    }

    [[nodiscard, gnu::always_inline]] Array8 max(const Array8& other) const {
        return other.numbers_ > numbers_ ? other.numbers_ : numbers_;
    }

    [[nodiscard, gnu::always_inline]] Array8 square() const { return numbers_ * numbers_; }

    [[nodiscard, gnu::always_inline]] Array8 abs() const { return max(-*this); }

    /// Cut to whole numbers, for numbers below 2^31 in magnitude.
    [[nodiscard, gnu::always_inline]] Integers truncated() const {
        return __builtin_convertvector(numbers_, Integers);
    }

    [[gnu::always_inline]] static Array8 from(const Integers& whole) {
        return __builtin_convertvector(whole, Numbers);
    }

    [[nodiscard]] float lowest() const {
        const Array8 halves = min(swapped_halves());
        const float a = halves[1] < halves[0] ? halves[1] : halves[0];
        const float b = halves[3] < halves[2] ? halves[3] : halves[2];
        return b < a ? b : a;
    }

    [[nodiscard]] float highest() const {
        const Array8 halves = max(swapped_halves());
        const float a = halves[1] > halves[0] ? halves[1] : halves[0];
        const float b = halves[3] > halves[2] ? halves[3] : halves[2];
        return b > a ? b : a;
    }

    /// Of lanes i and i + 4 first, then of neighbours.
    [[nodiscard]] float sum() const {
        const Array8 halves = *this + swapped_halves();
        return (halves[0] + halves[1]) + (halves[2] + halves[3]);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        for (std::ptrdiff_t i = 0; i < 8; ++i) {
            archive((*this)[i]);
        }
    }

  private:
    [[nodiscard, gnu::always_inline]] Array8 swapped_halves() const {
        return __builtin_shufflevector(numbers_, numbers_, 4, 5, 6, 7, 0, 1, 2, 3);
    }

    Numbers numbers_;
};

}  // namespace zoned
