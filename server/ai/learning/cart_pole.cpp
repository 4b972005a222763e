#include "server/ai/learning/cart_pole.h"

#include "shared/core/elementary/elementary.h"

#include <array>
#include <cmath>
#include <numbers>

namespace zoned::ai::learning {

namespace {

constexpr double kGravity = 9.8;
constexpr double kPole = 0.1;        // kg
constexpr double kMass = 1.1;        // kg, with the cart
constexpr double kHalfLength = 0.5;  // m
constexpr double kForce = 10.0;      // N
constexpr double kStep = 0.02;       // s
constexpr double kWidest = 12.0 * std::numbers::pi / 180.0;
constexpr double kTrack = 2.4;

double mean_steps(const NeuralNetwork& network, core::Rng rng, int episodes) {
    int steps = 0;
    for (int e = 0; e < episodes; ++e) {
        steps += steps_held(network, CartPole::start(rng));
    }
    return static_cast<double>(steps) / episodes;
}

}  // namespace

CartPole CartPole::start(core::Rng& rng) {
    CartPole pole;
    for (double* number : {&pole.x, &pole.speed, &pole.angle, &pole.turning}) {
        *number = static_cast<double>(rng.range(-0.05F, 0.05F));
    }
    return pole;
}

void CartPole::step(bool push_right) {
    const auto [sine, cosine] = elementary::sincos(angle);
    const double force = push_right ? kForce : -kForce;
    const double pull = (force + kPole * kHalfLength * turning * turning * sine) / kMass;
    const double turning_up = (kGravity * sine - cosine * pull) /
                              (kHalfLength * (4.0 / 3.0 - kPole * cosine * cosine / kMass));
    const double speed_up = pull - kPole * kHalfLength * turning_up * cosine / kMass;
    x += kStep * speed;
    speed += kStep * speed_up;
    angle += kStep * turning;
    turning += kStep * turning_up;
}

bool CartPole::over() const {
    return !(std::abs(x) <= kTrack && std::abs(angle) <= kWidest);
}

int steps_held(const NeuralNetwork& network, CartPole pole) {
    std::array<float, kMaxValues> values;
    int steps = 0;
    while (steps < kCartPoleSteps) {
        const float in[] = {static_cast<float>(pole.x / kTrack),
                            static_cast<float>(pole.speed / 2.0),
                            static_cast<float>(pole.angle / kWidest),
                            static_cast<float>(pole.turning / 2.0)};
        float out = 0.0F;
        evaluate(network, in, values, std::span(&out, 1));
        pole.step(out > 0.0F);
        if (pole.over()) {
            break;
        }
        ++steps;
    }
    return steps;
}

double CartPoleTask::fitness(const NeuralNetwork& network, std::uint64_t course) const {
    return mean_steps(network, core::Rng(course, 0xCA27), kEpisodes);
}

double CartPoleTask::score(const NeuralNetwork& network, std::uint64_t course) const {
    return mean_steps(network, core::Rng(course, 0x7E57), 100);
}

}  // namespace zoned::ai::learning
