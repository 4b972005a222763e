// Suite `elementary`: what the functions that give the same bits everywhere cost beside the C
// library's, which do not.
#include "tests/bench/comparison.h"
#include "shared/core/elementary/elementary.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace zoned::bench {

namespace {

constexpr std::size_t kArguments = 100'000;

/// Both of an angle count as one function: callers need both.
struct ElementaryScene {
    const char* name;
    double least;
    double most;
    double (*ours)(double);
    double (*library)(double);
    long double (*truth)(long double);
};

template <class Number>
double both_ours(double angle) {
    const auto both = elementary::sincos(static_cast<Number>(angle));
    return static_cast<double>(both.sine + both.cosine);
}

template <class Number>
double both_of_library(double angle) {
    const auto x = static_cast<Number>(angle);
    return static_cast<double>(std::sin(x) + std::cos(x));
}

constexpr std::array kScenes{
    ElementaryScene{"sincos", -4.0, 4.0, both_ours<double>, both_of_library<double>, nullptr},
    ElementaryScene{"sincos_float", -4.0, 4.0, both_ours<float>, both_of_library<float>, nullptr},
    ElementaryScene{"atan2",
                    -2.0,
                    2.0,
                    [](double x) { return elementary::atan2(x, 1.0); },
                    [](double x) { return std::atan2(x, 1.0); },
                    [](long double x) {
                        return std::atan2(x, 1.0L);
                    }},
    ElementaryScene{"exp",
                    -20.0,
                    20.0,
                    [](double x) { return elementary::exp(x); },
                    [](double x) { return std::exp(x); },
                    [](long double x) {
                        return std::exp(x);
                    }},
    ElementaryScene{"log",
                    0.1,
                    10.0,
                    [](double x) { return elementary::log(x); },
                    [](double x) { return std::log(x); },
                    [](long double x) {
                        return std::log(x);
                    }}};

class ElementaryTrial : public JudgedTrial {
  public:
    ElementaryTrial(const ElementaryScene& scene, double (*function)(double))
        : scene_(scene),
          function_(function) {
        core::Rng rng(5);
        for (double& x : arguments_) {
            x = scene.least + (scene.most - scene.least) * rng.next() * 0x1p-32;
        }
    }

    void frame() override {
        for (const double x : arguments_) {
            sum_ += function_(x);
        }
    }

    /// The greatest error, of functions that a long double tells the truth of.
    void judge(Row& row) override {
        row.error_unit = "ulp";
        row.metric("calls", static_cast<double>(kArguments));
        row.metric("sum", sum_);
        if (scene_.truth == nullptr) {
            return;
        }
        for (const double x : arguments_) {
            const long double truth = scene_.truth(static_cast<long double>(x));
            int exponent = 0;
            std::frexp(static_cast<double>(truth), &exponent);
            const long double ulp =
                std::ldexp(1.0L, exponent - std::numeric_limits<double>::digits);
            const long double off = static_cast<long double>(function_(x)) - truth;
            row.error = std::max(row.error, static_cast<double>(std::abs(off) / ulp));
        }
    }

  private:
    const ElementaryScene& scene_;
    double (*function_)(double);
    std::vector<double> arguments_ = std::vector<double>(kArguments);
    double sum_ = 0.0;
};

void run_elementary(Session& session) {
    for (const ElementaryScene& scene : kScenes) {
        if (!session.wants_scene(scene.name)) {
            continue;
        }
        session.progress(std::string("elementary ") + scene.name);
        const auto as = [&](const char* name, const char* peer, double (*function)(double)) {
            return Method{name, peer, [&scene, function] {
                              return std::make_unique<ElementaryTrial>(scene, function);
                          }};
        };
        session.add(compare(
            "elementary",
            scene.name,
            "",
            wanted(session, {as("default", "", scene.ours), as("default", "libm", scene.library)}),
            {2, session.quick ? 5 : 40, session.quick ? 1 : session.repeats}));
    }
}

const Registration kElementary({"elementary",
                                "sines, arcs, exponentials: 100,000 calls, greatest error",
                                {"sincos", "sincos_float", "atan2", "exp", "log"},
                                {"default", "libm/default"},
                                run_elementary});

}  // namespace

}  // namespace zoned::bench
