#include "server/ai/learning/neural_network.h"

#include "server/ai/learning/descent.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace zoned::ai::learning {
namespace {

NeuralNetwork random_network(std::span<const std::size_t> layers, std::uint64_t seed) {
    NeuralNetwork network = dense(layers);
    core::Rng rng(seed);
    randomise(network, rng);
    for (const NeuralNetwork::Neuron& node : network.nodes) {
        network.parameters[node.first] = rng.range(-0.5F, 0.5F);
    }
    return network;
}

constexpr std::array<std::size_t, 4> kShape{5, 9, 7, 3};

TEST(Squash, IsWithinItsPromiseOfTanhRisesAndIsOdd) {
    double worst = 0.0;
    float before = -1.0F;
    for (int i = -50000; i <= 50000; ++i) {
        const float x = static_cast<float>(i) * 1e-4F;
        const float y = squash(x);
        worst =
            std::max(worst, std::abs(static_cast<double>(y) - std::tanh(static_cast<double>(x))));
        // Where the slope is 0, a step of 1e-4 in the argument may round to either side.
        EXPECT_GE(y, before - 2e-7F);
        EXPECT_EQ(y, -squash(-x));
        before = y;
    }
    EXPECT_LT(worst, 0.0236);
    EXPECT_GT(worst, 0.02);  // else the comment promises too little
    EXPECT_EQ(squash(3.0F), 1.0F);
    EXPECT_EQ(squash(1e30F), 1.0F);
    EXPECT_EQ(squash(-std::numeric_limits<float>::infinity()), -1.0F);
    EXPECT_TRUE(std::isnan(squash(std::numeric_limits<float>::quiet_NaN())));
}

TEST(Squash, HasTheSlopeOfItsDifferences) {
    for (float x = -3.5F; x < 3.5F; x += 0.0371F) {
        constexpr float kH = 1.0F / 256.0F;
        const float measured = (squash(x + kH) - squash(x - kH)) / (2.0F * kH);
        // Third derivatives stay below 2: 2 h^2 / 6, and rounding of 2^-24 / h.
        EXPECT_NEAR(squash_slope(x), measured, 5e-5F) << x;
    }
}

TEST(NeuralNetwork, EvaluatesWhatItsDefinitionSays) {
    // Two inputs; a node 1 + 2 a - b, linear; a node squash(0.5 + node); the output is the second.
    NeuralNetwork network;
    network.inputs = 2;
    network.nodes = {{0, 2, Activation::kLinear}, {3, 1, Activation::kSquash}};
    network.parameters = {1.0F, 2.0F, -1.0F, 0.5F, 1.0F};
    network.source = {0, 0, 1, 0, 2};
    network.outputs = {3};
    ASSERT_EQ(defect_of(network), "");
    std::array<float, 4> values{};
    float out = 0.0F;
    evaluate(network, std::array{0.25F, 1.0F}, values, std::span(&out, 1));
    EXPECT_EQ(values[2], 0.5F);
    EXPECT_EQ(out, 28.0F / 36.0F);  // squash(1) = (27 + 1) / (27 + 9)
}

TEST(NeuralNetwork, AllocatesNothing) {
    const NeuralNetwork network = random_network(kShape, 3);
    std::vector<float> values(network.values());
    std::array<float, 3> out{};
    const std::uint64_t allocated = allocation_count();
    evaluate(network, std::array{1.0F, -2.0F, 0.5F, 0.0F, 3.0F}, values, out);
    EXPECT_EQ(allocation_count(), allocated);
}

TEST(NeuralNetwork, FromOutsideIsCheckedAgainstEveryKindOfDamage) {
    const NeuralNetwork good = random_network(kShape, 3);
    EXPECT_EQ(defect_of(good), "");
    const auto broken = [&good](const auto& change) {
        NeuralNetwork network = good;
        change(network);
        return !defect_of(network).empty();
    };
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.inputs = 0; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.inputs = ~std::size_t{0}; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.inputs = 4; }));  // then a node reads itself
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.outputs.clear(); }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.outputs[1] = 999; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.parameters.pop_back(); }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) {
        n.nodes.pop_back();
        n.outputs.pop_back();
    }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.nodes[2].first += 1; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.nodes[2].links = 0xFFFFFFFFU; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.nodes.back().links += 1; }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.source[2] = 5; }));  // the first node: itself
    EXPECT_TRUE(broken(
        [](NeuralNetwork& n) { n.parameters[4] = std::numeric_limits<float>::quiet_NaN(); }));
    EXPECT_TRUE(broken([](NeuralNetwork& n) { n.nodes.resize(kMaxValues + 1); }));
}

TEST(AddGradient, IsTheSlopeOfTheErrorInEveryParameter) {
    NeuralNetwork network = random_network(kShape, 5);
    const std::array<float, 5> in{0.3F, -0.7F, 1.1F, 0.2F, -0.4F};
    const std::array<float, 3> wanted{0.5F, -0.5F, 0.1F};
    std::vector<float> values(network.values());
    std::vector<float> sums(network.values());
    std::vector<float> blame(network.values());
    std::vector<float> gradient(network.parameters.size(), 0.0F);
    add_gradient(network, in, wanted, values, sums, blame, gradient);
    Samples one{5, 3, {in.begin(), in.end()}, {wanted.begin(), wanted.end()}};
    constexpr float kH = 1.0F / 128.0F;
    for (std::size_t p = 0; p < gradient.size(); ++p) {
        const float at = network.parameters[p];
        network.parameters[p] = at + kH;
        const double up = 3.0 * mean_squared_error(network, one);
        network.parameters[p] = at - kH;
        const double down = 3.0 * mean_squared_error(network, one);
        network.parameters[p] = at;
        // Central differences err by h^2 / 6 times a third derivative of some units.
        EXPECT_NEAR(gradient[p], (up - down) / (2.0 * kH), 1e-3) << p;
    }
}

TEST(Descent, FitsASmoothFunctionAndResumesBitForBit) {
    Samples samples;
    samples.inputs = 2;
    samples.outputs = 1;
    core::Rng rng(1);
    for (int i = 0; i < 400; ++i) {
        const std::array<float, 2> x{rng.range(-1.0F, 1.0F), rng.range(-1.0F, 1.0F)};
        samples.add(x, std::array{0.8F * x[0] * x[1]});
    }
    NeuralNetwork network = random_network(std::array<std::size_t, 3>{2, 12, 1}, 7);
    Descent descent({0.01F, 16}, network, 9);
    for (int epoch = 0; epoch < 100; ++epoch) {
        descent.epoch(network, samples);
    }
    NeuralNetwork resumed = network;
    Descent other({0.01F, 16}, resumed, 1);
    other.restore(descent.state());
    for (int epoch = 0; epoch < 100; ++epoch) {
        descent.epoch(network, samples);
        other.epoch(resumed, samples);
    }
    EXPECT_EQ(network, resumed);
    EXPECT_EQ(descent.state(), other.state());
    // A constant errs by the variance of 0.8 x y, 0.64 / 9; a tenth of its deviation is 1 % of it.
    EXPECT_NEAR(error_of_best_constant(samples), 0.64 / 9.0, 0.02);
    EXPECT_LT(mean_squared_error(network, samples), 0.01 * error_of_best_constant(samples));
}

}  // namespace
}  // namespace zoned::ai::learning
