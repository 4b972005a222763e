// Elementary functions: their errors, their special values, and that their bits are those of every
// other build.
#include "shared/core/elementary/elementary.h"

#include "tests/scenario/elementary_bits.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace zoned::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

static_assert(LDBL_MANT_DIG >= 64, "a reference of 11 bits more");

/// The unit in the last place of a result, of the binade that it lies in.
template <class Number>
long double ulp(long double of) {
    using Limits = std::numeric_limits<Number>;
    int exponent = 0;
    std::frexp(std::max(std::abs(of), static_cast<long double>(Limits::min())), &exponent);
    return std::ldexp(1.0L, exponent - Limits::digits);
}

/// How far a result lies from the true one, which the C library's long doubles give to 2^-11 ulp of
/// a double. Where one of the two is no plain number, both have to be the same.
template <class Number>
double error(Number result, long double truth) {
    const auto rounded = static_cast<Number>(truth);
    if (std::isnan(truth) || std::isnan(result)) {
        return std::isnan(truth) && std::isnan(result) ? 0.0 : kInfinity;
    }
    if (std::isinf(rounded) || std::isinf(result)) {
        // Just above the largest number, the library may round down what is rounded up here.
        return rounded == result ? 0.0 : std::isinf(truth) || std::isinf(result) ? 1.0 : kInfinity;
    }
    return static_cast<double>(std::abs(static_cast<long double>(result) - truth) /
                               ulp<Number>(truth));
}

/// Arguments spread evenly over an interval.
class Spread {
  public:
    Spread(double from, double to, std::uint64_t seed = 11) : from_(from), to_(to), rng_(seed) {}

    double next() {
        const double share = rng_.next() * 0x1p-32 + rng_.next() * 0x1p-64;
        return from_ + (to_ - from_) * share;
    }

  private:
    double from_;
    double to_;
    core::Rng rng_;
};

/// Numbers of all binades, of both signs.
class AllBinades {
  public:
    explicit AllBinades(std::uint64_t seed = 12) : rng_(seed) {}

    double next() {
        for (;;) {
            const std::uint64_t high = rng_.next();
            const auto number = std::bit_cast<double>(high << 32 | rng_.next());
            if (std::isfinite(number)) {
                return number;
            }
        }
    }

  private:
    core::Rng rng_;
};

struct Worst {
    double error = 0.0;
    double at = 0.0;
};

constexpr int kArguments = 300'000;

template <class Arguments, class Function, class Truth>
Worst worst_of(Arguments arguments, Function function, Truth truth) {
    Worst worst;
    for (int i = 0; i < kArguments; ++i) {
        const double x = arguments.next();
        const double e = error(function(x), truth(static_cast<long double>(x)));
        if (!(e <= worst.error)) {
            worst = {e, x};
        }
    }
    return worst;
}

void expect_within(const char* name, const Worst& worst, double bound) {
    std::printf("%-28s %.4f ulp at %a\n", name, worst.error, worst.at);
    EXPECT_LE(worst.error, bound) << name << " at " << worst.at;
}

double sine(double x) {
    return sin(x);
}

double cosine(double x) {
    return cos(x);
}

TEST(ElementarySines, StayWithinOneUlpAtAnyAngle) {
    const auto true_sine = [](long double x) {
        return std::sin(x);
    };
    const auto true_cosine = [](long double x) {
        return std::cos(x);
    };
    for (const double most : {0.8, 7.0, 1e3, 0x1p20, 1e9}) {
        expect_within("sin", worst_of(Spread(-most, most), sine, true_sine), 1.0);
        expect_within("cos", worst_of(Spread(-most, most), cosine, true_cosine), 1.0);
    }
    expect_within("sin of all binades", worst_of(AllBinades(), sine, true_sine), 1.0);
    expect_within("cos of all binades", worst_of(AllBinades(), cosine, true_cosine), 1.0);
}

/// Multiples of pi / 2 leave the smallest rests.
TEST(ElementarySines, KeepTheirDigitsBesideMultiplesOfAQuarterTurn) {
    Worst of_sine;
    Worst of_cosine;
    for (int k = 1; k < 400'000; ++k) {
        const auto x = static_cast<double>(static_cast<long double>(k) * 1.57079632679489661923L);
        const auto exact = static_cast<long double>(x);
        of_sine = std::max(of_sine, {error(sin(x), std::sin(exact)), x}, [](auto& a, auto& b) {
            return a.error < b.error;
        });
        of_cosine = std::max(of_cosine, {error(cos(x), std::cos(exact)), x}, [](auto& a, auto& b) {
            return a.error < b.error;
        });
    }
    expect_within("sin beside k pi / 2", of_sine, 1.0);
    expect_within("cos beside k pi / 2", of_cosine, 1.0);
    // The double that is nearest to any multiple of pi / 2 (Muller, "Elementary Functions", 11.2).
    const double nearest = std::ldexp(6381956970095103.0, 797);
    EXPECT_DOUBLE_EQ(cos(nearest), -4.6871659242546276e-19);
    EXPECT_EQ(std::abs(sin(nearest)), 1.0);
}

TEST(ElementaryTangent, StaysWithinThreeUlp) {
    expect_within("tan",
                  worst_of(
                      Spread(-10.0, 10.0),
                      [](double x) { return tan(x); },
                      [](long double x) { return std::tan(x); }),
                  3.0);
}

/// Draws the other argument of a function of two along with the first.
template <class Arguments>
struct PairOf {
    Arguments first;
    Arguments second;
    double& other;

    double next() {
        other = second.next();
        return first.next();
    }
};

TEST(ElementaryArcs, StayWithinTheirBounds) {
    double y = 0.0;
    const auto of = [&](double x) {
        return atan2(y, x);
    };
    const auto truth = [&](long double x) {
        return std::atan2(static_cast<long double>(y), x);
    };
    const auto worst_arc = [&](auto xs, auto ys) {
        return worst_of(PairOf<decltype(xs)>{xs, ys, y}, of, truth);
    };
    expect_within("atan2", worst_arc(Spread(-1.0, 1.0, 3), Spread(-1.0, 1.0)), 2.0);
    expect_within("atan2 of small arcs", worst_arc(Spread(1.0, 40.0, 3), Spread(-1.0, 1.0)), 2.0);
    expect_within("atan2 of all binades", worst_arc(AllBinades(3), AllBinades()), 2.0);
    expect_within("acos",
                  worst_of(
                      Spread(-1.0, 1.0),
                      [](double x) { return acos(x); },
                      [](long double x) { return std::acos(x); }),
                  4.0);
}

TEST(ElementaryExponentials, StayWithinTheirBounds) {
    const auto of_exp = [](double x) {
        return exp(x);
    };
    const auto true_exp = [](long double x) {
        return std::exp(x);
    };
    expect_within("exp", worst_of(Spread(-746.0, 709.7), of_exp, true_exp), 1.0);
    expect_within("exp of small numbers", worst_of(Spread(-1.0, 1.0), of_exp, true_exp), 1.0);
    expect_within("exp of all binades", worst_of(AllBinades(), of_exp, true_exp), 1.0);
    const auto of_expm1 = [](double x) {
        return expm1(x);
    };
    const auto true_expm1 = [](long double x) {
        return std::expm1(x);
    };
    expect_within("expm1", worst_of(Spread(-50.0, 709.0), of_expm1, true_expm1), 2.0);
    expect_within("expm1 of small numbers", worst_of(Spread(-2.0, 2.0), of_expm1, true_expm1), 2.0);
    expect_within("expm1 of all binades", worst_of(AllBinades(), of_expm1, true_expm1), 2.0);
}

TEST(ElementaryLogarithm, StaysWithinOneUlp) {
    const auto of = [](double x) {
        return log(std::abs(x));
    };
    const auto truth = [](long double x) {
        return std::log(std::abs(x));
    };
    expect_within("log of all binades", worst_of(AllBinades(), of, truth), 1.0);
    expect_within("log about 1", worst_of(Spread(0.5, 2.0), of, truth), 1.0);
    expect_within("log close to 1", worst_of(Spread(0.999, 1.001), of, truth), 1.0);
}

TEST(ElementaryPower, StaysWithinItsBound) {
    Spread exponents(-3.0, 3.0, 3);
    Spread bases(0.0, 50.0);
    double share = 0.0;
    for (int i = 0; i < kArguments; ++i) {
        const double x = bases.next();
        const double y = exponents.next();
        const long double truth =
            std::pow(static_cast<long double>(x), static_cast<long double>(y));
        share = std::max(share, error(pow(x, y), truth) / (2.0 + 3.0 * std::abs(y * std::log(x))));
    }
    std::printf("%-28s %.4f of its bound\n", "pow", share);
    EXPECT_LE(share, 1.0);
}

TEST(ElementaryHypotenuse, StaysWithinItsBound) {
    expect_within("hypot",
                  worst_of(
                      Spread(-10.0, 10.0),
                      [](double x) { return hypot(x, 1.25); },
                      [](long double x) { return std::hypot(x, 1.25L); }),
                  1.25);
}

using OfFloat = std::function<float(float)>;
using TrueOfFloat = std::function<long double(long double)>;

struct FloatSubject {
    const char* name;
    OfFloat of;
    TrueOfFloat truth;
};

/// All floats with ZONED_ELEMENTARY_STRIDE=1 (a target of its own), else one of 16,411.
std::uint32_t stride() {
    const char* asked = std::getenv("ZONED_ELEMENTARY_STRIDE");
    return asked == nullptr ? 16'411U : static_cast<std::uint32_t>(std::stoul(asked));
}

TEST(ElementaryFloats, AreRoundedCorrectlyButForHardlyAny) {
    const std::vector<FloatSubject> subjects = {
        {"sin",
         [](float x) { return sin(x); },
         [](long double x) {
             return std::sin(x);
         }},
        {"cos",
         [](float x) { return cos(x); },
         [](long double x) {
             return std::cos(x);
         }},
        {"exp",
         [](float x) { return exp(x); },
         [](long double x) {
             return std::exp(x);
         }},
        {"expm1",
         [](float x) { return expm1(x); },
         [](long double x) {
             return std::expm1(x);
         }},
        {"log",
         [](float x) { return log(x); },
         [](long double x) {
             return std::log(x);
         }},
        {"acos",
         [](float x) { return acos(x); },
         [](long double x) {
             return std::acos(x);
         }},
        {"atan2(x, 1)",
         [](float x) { return atan2(x, 1.0F); },
         [](long double x) {
             return std::atan2(x, 1.0L);
         }},
        {"hypot(x, 3)",
         [](float x) { return hypot(x, 3.0F); },
         [](long double x) {
             return std::hypot(x, 3.0L);
         }},
        {"pow(x, 0.17)",
         [](float x) { return pow(std::abs(x), 0.17F); },
         [](long double x) {
             return std::pow(std::abs(x), static_cast<long double>(0.17F));
         }}};
    const std::uint32_t step = stride();
    for (const FloatSubject& subject : subjects) {
        double worst = 0.0;
        float at = 0.0F;
        std::uint64_t unrounded = 0;
        std::uint64_t count = 0;
        for (std::uint64_t bits = 0; bits <= 0xffffffffU; bits += step) {
            const auto x = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
            const long double truth = subject.truth(static_cast<long double>(x));
            const float result = subject.of(x);
            ++count;
            if (result == static_cast<float>(truth) || (std::isnan(truth) && std::isnan(result))) {
                continue;
            }
            ++unrounded;
            const double e = error(result, truth);
            if (!(e <= worst)) {
                worst = e;
                at = x;
            }
        }
        std::printf("%-14s %11llu floats, %llu not rounded correctly, worst %.6f ulp at %a\n",
                    subject.name,
                    static_cast<unsigned long long>(count),
                    static_cast<unsigned long long>(unrounded),
                    worst,
                    static_cast<double>(at));
        EXPECT_LE(worst, 0.501) << subject.name;
        EXPECT_LE(unrounded, count / 1000) << subject.name;
    }
}

void expect_same(double result, double expected) {
    if (std::isnan(expected)) {
        EXPECT_TRUE(std::isnan(result));
    } else {
        EXPECT_EQ(std::bit_cast<std::uint64_t>(result), std::bit_cast<std::uint64_t>(expected))
            << result << " in place of " << expected;
    }
}

/// Annex F of the C standard.
TEST(ElementarySpecialValues, AreThoseOfTheCStandard) {
    expect_same(sin(0.0), 0.0);
    expect_same(sin(-0.0), -0.0);
    expect_same(sin(kInfinity), kNone);
    expect_same(cos(-0.0), 1.0);
    expect_same(cos(-kInfinity), kNone);
    expect_same(sin(kNone), kNone);
    expect_same(tan(-0.0), -0.0);
    expect_same(exp(0.0), 1.0);
    expect_same(exp(kInfinity), kInfinity);
    expect_same(exp(-kInfinity), 0.0);
    expect_same(exp(kNone), kNone);
    expect_same(exp(709.8), kInfinity);
    expect_same(exp(-745.2), 0.0);
    expect_same(exp(-745.1), 0x1p-1074);
    expect_same(expm1(-0.0), -0.0);
    expect_same(expm1(-kInfinity), -1.0);
    expect_same(expm1(kInfinity), kInfinity);
    expect_same(log(1.0), 0.0);
    expect_same(log(0.0), -kInfinity);
    expect_same(log(-0.0), -kInfinity);
    expect_same(log(-1.0), kNone);
    expect_same(log(kInfinity), kInfinity);
    expect_same(pow(0.0, 0.0), 1.0);
    expect_same(pow(0.0, 2.0), 0.0);
    expect_same(pow(0.0, -2.0), kInfinity);
    expect_same(pow(kNone, 0.0), 1.0);
    expect_same(pow(1.0, kNone), 1.0);
    expect_same(pow(kInfinity, -1.0), 0.0);
    expect_same(acos(1.0), 0.0);
    expect_same(acos(-1.0), std::acos(-1.0));
    expect_same(acos(1.5), kNone);
    for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kNone}) {
        for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kNone}) {
            expect_same(atan2(y, x), std::atan2(y, x));
        }
    }
}

/// Another bit is another simulation: its generation rises with it.
TEST(ElementaryBits, AreThoseOfAllBuilds) {
    constexpr std::uint64_t kBits[] = {0x2afb504af05b4a24,
                                       0x571f258df5cd4e6a,
                                       0x0690866ea5e8019f,
                                       0x6de55cdf27740db8,
                                       0x500367dd43c75107,
                                       0xbda81463ed2edddb,
                                       0x143ddb66a6bec6a6,
                                       0xb466042f81b5c4e8,
                                       0xfad2cef7d6ff8902,
                                       0x0d03495befa15b6d};
    static_assert(std::size(kBits) == scenario::kElementarySubjects.size());
    for (std::size_t i = 0; i < std::size(kBits); ++i) {
        const scenario::ElementarySubject& subject = scenario::kElementarySubjects[i];
        const std::uint64_t bits = scenario::elementary_bits(subject);
        EXPECT_EQ(bits, kBits[i]) << subject.name << ": 0x" << std::hex << bits;
    }
}

}  // namespace
}  // namespace zoned::elementary
