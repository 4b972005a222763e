// build: hot loops
#include "server/ai/learning/descent.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace zoned::ai::learning {

namespace {

constexpr float kMeanDecay = 0.9F;
constexpr float kSquareDecay = 0.999F;
constexpr float kSmall = 1e-8F;

}  // namespace

void Samples::add(std::span<const float> from, std::span<const float> wanted) {
    ZONED_ASSERT(from.size() == inputs && wanted.size() == outputs, "samples are of one shape");
    in.insert(in.end(), from.begin(), from.end());
    out.insert(out.end(), wanted.begin(), wanted.end());
}

double mean_squared_error(const NeuralNetwork& network, const Samples& samples) {
    std::vector<float> values(network.values());
    std::vector<float> out(samples.outputs);
    double sum = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        evaluate(network, samples.in_of(i), values, out);
        for (std::size_t o = 0; o < out.size(); ++o) {
            const double off = static_cast<double>(out[o]) - samples.out_of(i)[o];
            sum += off * off;
        }
    }
    return samples.size() == 0 ? 0.0 : sum / static_cast<double>(samples.out.size());
}

double error_of_best_constant(const Samples& samples) {
    const auto count = static_cast<double>(samples.size());
    double sum = 0.0;
    for (std::size_t o = 0; o < samples.outputs; ++o) {
        double mean = 0.0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            mean += samples.out_of(i)[o] / count;
        }
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const double off = samples.out_of(i)[o] - mean;
            sum += off * off;
        }
    }
    return samples.size() == 0 ? 0.0 : sum / static_cast<double>(samples.out.size());
}

float add_gradient(const NeuralNetwork& network,
                   std::span<const float> in,
                   std::span<const float> wanted,
                   std::span<float> values,
                   std::span<float> sums,
                   std::span<float> blame,
                   std::span<float> gradient) {
    const std::size_t inputs = network.inputs;
    std::copy(in.begin(), in.end(), values.begin());
    for (std::size_t n = 0; n < network.nodes.size(); ++n) {
        const NeuralNetwork::Neuron& node = network.nodes[n];
        float sum = network.parameters[node.first];
        for (std::uint32_t p = node.first + 1; p <= node.first + node.links; ++p) {
            sum += network.parameters[p] * values[network.source[p]];
        }
        sums[inputs + n] = sum;
        values[inputs + n] = node.activation == Activation::kSquash ? squash(sum) : sum;
    }
    std::fill(blame.begin(), blame.end(), 0.0F);
    float error = 0.0F;
    for (std::size_t o = 0; o < wanted.size(); ++o) {
        const float off = values[network.outputs[o]] - wanted[o];
        error += off * off;
        blame[network.outputs[o]] += 2.0F * off;
    }
    for (std::size_t n = network.nodes.size(); n-- > 0;) {
        const NeuralNetwork::Neuron& node = network.nodes[n];
        const float slope =
            node.activation == Activation::kSquash ? squash_slope(sums[inputs + n]) : 1.0F;
        const float here = blame[inputs + n] * slope;
        gradient[node.first] += here;
        for (std::uint32_t p = node.first + 1; p <= node.first + node.links; ++p) {
            gradient[p] += here * values[network.source[p]];
            blame[network.source[p]] += here * network.parameters[p];
        }
    }
    return error;
}

Descent::Descent(const DescentSettings& settings, const NeuralNetwork& network, std::uint64_t seed)
    : settings_(settings),
      values_(network.values()),
      sums_(network.values()),
      blame_(network.values()),
      gradient_(network.parameters.size()) {
    state_.mean.assign(network.parameters.size(), 0.0F);
    state_.square.assign(network.parameters.size(), 0.0F);
    state_.rng = core::Rng(seed, 0xDE5CE47);
}

void Descent::restore(DescentState state) {
    ZONED_ASSERT(state.mean.size() == gradient_.size() && state.square.size() == gradient_.size(),
                 "a state belongs to its network");
    state_ = std::move(state);
}

double Descent::epoch(NeuralNetwork& network, const Samples& samples) {
    ZONED_ASSERT(samples.size() > 0 && samples.outputs == network.outputs.size(),
                 "there is something to learn");
    order_.resize(samples.size());
    std::iota(order_.begin(), order_.end(), 0U);
    for (std::size_t i = order_.size(); i > 1; --i) {
        std::swap(order_[i - 1], order_[state_.rng.below(static_cast<std::uint32_t>(i))]);
    }
    double error = 0.0;
    for (std::size_t begin = 0; begin < order_.size(); begin += settings_.batch) {
        const std::size_t end = std::min(order_.size(), begin + settings_.batch);
        std::fill(gradient_.begin(), gradient_.end(), 0.0F);
        for (std::size_t i = begin; i < end; ++i) {
            error += add_gradient(network,
                                  samples.in_of(order_[i]),
                                  samples.out_of(order_[i]),
                                  values_,
                                  sums_,
                                  blame_,
                                  gradient_);
        }
        step(network, end - begin);
    }
    return error / static_cast<double>(samples.out.size());
}

void Descent::step(NeuralNetwork& network, std::size_t samples) {
    state_.mean_decay *= static_cast<double>(kMeanDecay);
    state_.square_decay *= static_cast<double>(kSquareDecay);
    const auto mean_scale = static_cast<float>(1.0 / (1.0 - state_.mean_decay));
    const auto square_scale = static_cast<float>(1.0 / (1.0 - state_.square_decay));
    const float share = 1.0F / static_cast<float>(samples);
    for (std::size_t p = 0; p < gradient_.size(); ++p) {
        const float g = gradient_[p] * share;
        state_.mean[p] = kMeanDecay * state_.mean[p] + (1.0F - kMeanDecay) * g;
        state_.square[p] = kSquareDecay * state_.square[p] + (1.0F - kSquareDecay) * g * g;
        network.parameters[p] -= settings_.step * state_.mean[p] * mean_scale /
                                 (std::sqrt(state_.square[p] * square_scale) + kSmall);
    }
}

}  // namespace zoned::ai::learning
