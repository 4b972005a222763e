// ElementaryBits: what the elementary functions give for a fixed row of arguments, as one hash
// each: all builds, on all processors and in browsers, have to agree.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace zoned::scenario {

/// Arguments of all binades by turns with those of a usual size, then special values.
class ElementaryArguments {
  public:
    double number(int i) {
        constexpr std::array<double, 8> kSpecial = {
            0.0, -0.0, 1.0, -1.0, 0x1p-1074, 0x1.fffffffffffffp+1023, INFINITY, -INFINITY};
        if (i % 64 < static_cast<int>(kSpecial.size()) && i < 1024) {
            return kSpecial[static_cast<std::size_t>(i % 64)];
        }
        if (i % 2 == 0) {
            return 20.0 * static_cast<double>(rng_.range(-1.0F, 1.0F)) +
                   static_cast<double>(rng_.unit()) * 0x1p-24;
        }
        for (;;) {
            const std::uint64_t high = rng_.next();
            const auto bits = std::bit_cast<double>(high << 32 | rng_.next());
            if (std::isfinite(bits)) {
                return bits;
            }
        }
    }

  private:
    core::Rng rng_{2029};
};

struct ElementarySubject {
    std::string_view name;
    double (*of)(double x, double y);
    float (*of_float)(float x, float y);  ///< may be null
};

inline constexpr std::array<ElementarySubject, 10> kElementarySubjects = {
    {{"sin",
      [](double x, double) { return elementary::sin(x); },
      [](float x, float) {
          return elementary::sin(x);
      }},
     {"cos",
      [](double x, double) { return elementary::cos(x); },
      [](float x, float) {
          return elementary::cos(x);
      }},
     {"tan", [](double x, double) { return elementary::tan(x); }, nullptr},
     {"atan2",
      [](double x, double y) { return elementary::atan2(y, x); },
      [](float x, float y) {
          return elementary::atan2(y, x);
      }},
     {"acos",
      [](double x, double) { return elementary::acos(x / (1.0 + std::abs(x))); },
      [](float x, float) {
          return elementary::acos(x / (1.0F + std::abs(x)));
      }},
     {"exp",
      [](double x, double) { return elementary::exp(x); },
      [](float x, float) {
          return elementary::exp(x);
      }},
     {"expm1",
      [](double x, double) { return elementary::expm1(x); },
      [](float x, float) {
          return elementary::expm1(x);
      }},
     {"log",
      [](double x, double) { return elementary::log(std::abs(x)); },
      [](float x, float) {
          return elementary::log(std::abs(x));
      }},
     {"pow",
      [](double x, double y) { return elementary::pow(std::abs(x), y); },
      [](float x, float y) {
          return elementary::pow(std::abs(x), y);
      }},
     {"hypot",
      [](double x, double y) { return elementary::hypot(x, y); },
      [](float x, float y) {
          return elementary::hypot(x, y);
      }}}};

/// Of doubles and floats. Those that are not numbers count as one.
inline std::uint64_t elementary_bits(const ElementarySubject& subject) {
    constexpr int kArguments = 20'000;
    core::StateHash hash;
    const auto add = [&](auto number) {
        hash.add(std::isnan(number) ? static_cast<decltype(number)>(7.0) : number);
    };
    ElementaryArguments arguments;
    for (int i = 0; i < kArguments; ++i) {
        const double x = arguments.number(i);
        const double y = arguments.number(i + 32);
        add(subject.of(x, y));
        if (subject.of_float != nullptr) {
            add(subject.of_float(static_cast<float>(x), static_cast<float>(y)));
        }
    }
    return hash.value();
}

}  // namespace zoned::scenario
